#include "core/view/shade.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

namespace trimray::view {

double linear_from_srgb(double x) { return x <= 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4); }

double srgb_from_linear(double x) {
  if (!(x > 0.0)) return 0.0;
  if (x >= 1.0) return 1.0;
  return x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1.0 / 2.4) - 0.055;
}

namespace {

// x^(1 / 2.4) in [2^-9, 1] to kPowerError, from the power at the middle of one of 64 parts of x's octave and
// the binomial series about it.
class Power {
 public:
  static constexpr double kPowerError = 1e-14;  // relative

  Power() {
    for (int octave = 0; octave < kOctaves; ++octave) {
      for (int part = 0; part < kParts; ++part) {
        const double middle = std::ldexp(1.0 + (part + 0.5) / kParts, octave - kOctaves);
        middles_[octave * kParts + part] = {std::pow(middle, kExponent), 1.0 / middle};
      }
    }
  }

  double operator()(double x) const {
    const Middle& middle = middles_[(std::bit_cast<std::uint64_t>(x) >> 46) - kFirst];
    const double d = x * middle.inverse - 1.0;  // at most 1 / 128 from 0
    const double series = kC1 + d * (kC2 + d * (kC3 + d * (kC4 + d * (kC5 + d * kC6))));
    return middle.power + middle.power * (d * series);
  }

 private:
  static constexpr int kOctaves = 9, kParts = 64;
  static constexpr double kExponent = 1.0 / 2.4;
  static constexpr std::uint64_t kFirst = std::bit_cast<std::uint64_t>(1.0 / (1 << kOctaves)) >> 46;
  static constexpr double kC1 = kExponent, kC2 = kC1 * (kExponent - 1) / 2, kC3 = kC2 * (kExponent - 2) / 3,
                          kC4 = kC3 * (kExponent - 3) / 4, kC5 = kC4 * (kExponent - 4) / 5,
                          kC6 = kC5 * (kExponent - 5) / 6;
  struct Middle {
    double power = 0.0, inverse = 0.0;
  };
  std::array<Middle, kOctaves * kParts> middles_;
};

}  // namespace

float srgb_float_from_linear(double x) {
  static const Power power;
  if (!(x > 0.0031308 && x < 1.0)) return static_cast<float>(srgb_from_linear(x));
  const double encoded = 1.055 * power(x) - 0.055;
  // The float is certain where all that is near enough rounds to it.
  constexpr double kSlack = 64.0 * Power::kPowerError;
  const float low = static_cast<float>(encoded - kSlack), high = static_cast<float>(encoded + kSlack);
  return low == high ? low : static_cast<float>(srgb_from_linear(x));
}

Color linear_color(const float srgb[4]) {
  const auto channel = [](float x) { return linear_from_srgb(std::clamp(static_cast<double>(x), 0.0, 1.0)); };
  return {{channel(srgb[0]), channel(srgb[1]), channel(srgb[2])},
          std::clamp(static_cast<double>(srgb[3]), 0.0, 1.0)};
}

Lighting::Lighting(const dvec3& right, const dvec3& up_axis, const dvec3& forward)
    : key(glm::normalize(-0.75 * right + 0.70 * up_axis - 0.55 * forward)),
      fill(glm::normalize(0.85 * right + 0.15 * up_axis - 0.45 * forward)),
      up(up_axis) {}

namespace {

// Shares of the lights in the light that a white surface sends back; chosen on pictures of grey parts so that
// the three visible sides of a box differ clearly and none of them reaches white.
constexpr double kHeadlight = 0.32, kKey = 0.66, kFill = 0.10, kSurroundings = 0.12;
constexpr double kSpecular = 0.05;
constexpr dvec3 kInnerTint{0.85, 0.18, 0.35};  // linear; a colour that no metal has

// Lambert's cosine for a lamp so wide that it still shows at `wrap` beyond the horizon.
double soft(double cosine, double wrap) {
  const double x = std::max(0.0, (cosine + wrap) / (1.0 + wrap));
  return x * x;
}

// Phong's power, 24, without a call of std::pow for every ray.
double shininess(double cosine) {
  const double x2 = cosine * cosine, x4 = x2 * x2, x8 = x4 * x4;
  return x8 * x8 * x8;
}

}  // namespace

dvec3 shade(const Lighting& lighting, const dvec3& normal, const dvec3& dir, const dvec3& base,
            bool orientation, const Visibility& visibility) {
  const bool inner = glm::dot(normal, dir) > 0.0;
  const dvec3 n = inner ? -normal : normal;
  const double facing = std::clamp(-glm::dot(n, dir), 0.0, 1.0);
  double light = kHeadlight * facing;
  light += kKey * soft(glm::dot(n, lighting.key), 0.5) * visibility.key;
  light += kFill * soft(glm::dot(n, lighting.fill), 0.5) * visibility.fill;
  light += kSurroundings * (0.65 + 0.35 * glm::dot(n, lighting.up));
  light *= visibility.ambient;
  const dvec3 halfway = glm::normalize(lighting.key - dir);
  const double gloss = kSpecular * shininess(std::max(0.0, glm::dot(n, halfway))) * visibility.key;
  const dvec3 albedo = inner && orientation ? glm::mix(base, kInnerTint, 0.85) : base;
  return glm::clamp(albedo * light + dvec3(gloss), dvec3(0.0), dvec3(1.0));
}

Color Background::at(double height) const {
  const float w = static_cast<float>(std::clamp(height, 0.0, 1.0));
  float mixed[4];
  for (int i = 0; i < 4; ++i) mixed[i] = (1.0f - w) * top[i] + w * bottom[i];
  return linear_color(mixed);
}

}  // namespace trimray::view
