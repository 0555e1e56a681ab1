// Shading: the neutral look of a CAD part, and the colours behind it.
#pragma once

#include "core/base/types.h"

namespace trimray::view {

// sRGB transfer function (IEC 61966-2-1), one channel, both ways, [0, 1] -> [0, 1]; the two are inverse to
// 1e-7.
double linear_from_srgb(double encoded);
double srgb_from_linear(double linear);

// static_cast<float>(srgb_from_linear(linear)), bit by bit, at a fifth of its cost.
float srgb_float_from_linear(double linear);

// Linear colour with straight alpha.
struct Color {
  dvec3 rgb{0.0};
  double alpha = 1.0;
};
Color linear_color(const float srgb[4]);

// Lights ride with the camera: a headlight, and two soft lights from above left and from the right. A soft
// light wraps round the shape (wrapped Lambert), as a wide lamp does, so no surface turned to the eye is
// black. Both sides of a face are lit alike.
struct Lighting {
  dvec3 key{0.0}, fill{0.0};  // unit, towards the light, world
  dvec3 up{0.0};              // of the camera; the light from the surroundings comes from above
  Lighting() = default;
  Lighting(const dvec3& right, const dvec3& up_axis, const dvec3& forward);
};

// What part of each light comes to a surface point, 0 to 1; the headlight stands at the eye and comes to all.
struct Visibility {
  double key = 1.0, fill = 1.0;
  double ambient = 1.0;  // of everything, shine excepted: what narrow corners take
};

// Light that a surface point sends along -dir, linear, clamped to [0, 1]. normal: outward, unit; dir: the
// ray's direction, unit. orientation: tint faces that turn their inner side to the eye.
dvec3 shade(const Lighting& lighting, const dvec3& normal, const dvec3& dir, const dvec3& base,
            bool orientation, const Visibility& visibility = {});

// What is seen where no face is: one colour from the top of the picture to another at its bottom, blended in
// sRGB (which the eye finds even); alpha 0 in both is a transparent picture. sRGB-encoded, straight alpha.
struct Background {
  float top[4] = {1, 1, 1, 1};
  float bottom[4] = {1, 1, 1, 1};
  Color at(double height) const;  // 0 = top, 1 = bottom of the picture
};

}  // namespace trimray::view
