// The NURBS forms against closed forms, and the basis functions against independent identities.
#include "core/nurbs/surface.h"

#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "core/nurbs/bezier.h"
#include "core/nurbs/make_store.h"

using namespace trimray;
using namespace trimray::nurbs;

namespace {

constexpr double kPi = std::numbers::pi;

struct Named {
  const char* name;
  SurfaceForm form;
  Box2 box;
};

std::vector<Named> analytic_forms() {
  const Frame3 frame{{3.0, -2.0, 5.0}, {1.0, 0.3, -0.2}, {0.2, -0.1, 1.0}};
  std::vector<Named> all;
  all.push_back({"plane", make_plane(frame), {{-7.0, -3.0}, {2.0, 11.0}}});
  all.push_back({"cylinder", make_cylinder(frame, 4.0), {{0.0, -3.0}, {2 * kPi, 8.0}}});
  all.push_back({"cone", make_cone(frame, 4.0, 0.4), {{0.0, -20.0}, {2 * kPi, 8.0}}});
  all.push_back({"sphere", make_sphere(frame, 4.0), {{0.0, -kPi / 2}, {2 * kPi, kPi / 2}}});
  all.push_back({"torus", make_torus(frame, 6.0, 2.5), {{0.0, 0.0}, {2 * kPi, 2 * kPi}}});
  Surface mirrored = all.back().form.surface;
  SurfaceForm left = all.back().form;
  left.surface.y_axis = -mirrored.y_axis;
  set_closed_form_nurbs(left, {{-0.5, 1.0}, {4.0, 9.0}});
  all.push_back({"left-handed torus", left, {{-0.5, 1.0}, {4.0, 9.0}}});
  for (Named& n : all) set_closed_form_nurbs(n.form, n.box);
  return all;
}

double largest(const SurfaceForm& form) {
  double m = 0.0;
  for (const dvec4& h : form.ctrl_h) m = std::max(m, glm::length(project(h)));
  return m;
}

}  // namespace

TEST(Surface, nurbsFormEqualsClosedForm) {
  std::mt19937_64 random(1);
  for (const Named& n : analytic_forms()) {
    NurbsStore store;
    const Surface& f = store.surfaces[append_surface(store, n.form)];
    const double scale = glm::length(n.form.surface.location) + 40.0;
    std::uniform_real_distribution<double> u(n.box.lower.x, n.box.upper.x), v(n.box.lower.y, n.box.upper.y);
    for (int i = 0; i < 2000; ++i) {
      const dvec2 uv(u(random), v(random));
      const SurfacePoint a = evaluate(store, f, uv), b = evaluate_nurbs(store, f, uv);
      EXPECT_LE(glm::distance(a.p, b.p), 4e-15 * scale) << n.name;
      EXPECT_LE(glm::distance(a.du, b.du), 4e-14 * scale) << n.name;
      EXPECT_LE(glm::distance(a.dv, b.dv), 4e-14 * scale) << n.name;
    }
  }
}

TEST(Surface, derivativesAreThoseOfThePoint) {
  std::mt19937_64 random(2);
  for (const Named& n : analytic_forms()) {
    const SurfaceForm offset = as_offset(as_nurbs(n.form), 0.7);
    for (const SurfaceForm* form : {&n.form, &offset}) {
      std::uniform_real_distribution<double> part(0.1, 0.9);
      for (int i = 0; i < 50; ++i) {
        const dvec2 uv = n.box.lower + n.box.extent() * dvec2(part(random), part(random));
        const double h = 1e-5;
        const dvec3 du =
            (evaluate(view(*form), uv + dvec2(h, 0)).p - evaluate(view(*form), uv - dvec2(h, 0)).p) / (2 * h);
        const dvec3 dv =
            (evaluate(view(*form), uv + dvec2(0, h)).p - evaluate(view(*form), uv - dvec2(0, h)).p) / (2 * h);
        const SurfacePoint at = evaluate(view(*form), uv);
        EXPECT_LE(glm::distance(at.du, du), 1e-7) << n.name;
        EXPECT_LE(glm::distance(at.dv, dv), 1e-7) << n.name;
      }
    }
  }
}

TEST(Surface, offsetOfSphereIsSphere) {
  const SurfaceForm sphere = make_sphere({}, 4.0);
  const SurfaceForm offset = as_offset(as_nurbs(sphere), 1.5);
  const SurfaceForm larger = make_sphere({}, 5.5);
  for (double u = 0.0; u < 6.28; u += 0.37)
    for (double v = -1.5; v < 1.5; v += 0.31)
      EXPECT_LE(glm::distance(evaluate(view(offset), {u, v}).p, evaluate(view(larger), {u, v}).p), 1e-14);
  EXPECT_LE(glm::distance(evaluate(view(offset), {1.0, kPi / 2}).p, dvec3(0, 0, 5.5)), 1e-5);  // the pole
}

TEST(Surface, mapsKeepEveryKnotAndInvert) {
  for (const Named& n : analytic_forms()) {
    NurbsStore store;
    const Surface& f = store.surfaces[append_surface(store, n.form)];
    for (const double k : distinct_knots(n.form.knots_u, f.degree_u)) {
      EXPECT_EQ(nurbs_from_face(store, f.knots_u, f.map_u, k), k);
      EXPECT_EQ(face_from_nurbs(store, f.knots_u, f.map_u, k), k);
    }
    for (double t = 0.01; t < 1.0; t += 0.07) {
      const double u = f.domain.lower.x + t * (f.domain.upper.x - f.domain.lower.x);
      const double s = nurbs_from_face(store, f.knots_u, f.map_u, u);
      EXPECT_NEAR(face_from_nurbs(store, f.knots_u, f.map_u, s), u, 1e-14 * std::max(1.0, std::abs(u)));
    }
  }
  const SplineCurve<dvec3> h = hyperbola_basis(-1.7, 3.1);
  for (double t = -1.69; t < 3.1; t += 0.1) {
    const int span = find_span(h.knots, 2, t);
    const double s = map_parameter(h.map, h.knots[span], h.knots[span + 1], t).s;
    EXPECT_NEAR(unmap_parameter(h.map, h.knots[span], h.knots[span + 1], s), t, 4e-15);
    Basis b;
    basis_functions(h.knots, 2, span, s, 0, b);
    dvec3 p(0.0);
    for (int i = 0; i < 3; ++i) p += b.value[0][i] * h.ctrl[span - 2 + i];
    EXPECT_LE(glm::distance(project(p), dvec2(std::cosh(t), std::sinh(t))), 4e-15 * std::cosh(t));
  }
}

TEST(Surface, periodicDirectionsWrap) {
  const SurfaceForm torus = as_nurbs(make_torus({}, 6.0, 2.5));
  for (double u = 0.1; u < 6.0; u += 0.9)
    EXPECT_LE(glm::distance(evaluate(view(torus), {u, 1.0}).p,
                            evaluate(view(torus), {u + 4 * kPi, 1.0 - 2 * kPi}).p),
              1e-13);
}

TEST(Surface, bezierPatchesEqualEvaluation) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> coordinate(-5.0, 5.0), weight(0.3, 2.0), unit(0.0, 1.0);
  const std::vector<double> ku = {0, 0, 0, 0, 1, 1, 2.5, 4, 4, 4, 4}, kv = {-1, -1, -1, 0.5, 1, 3, 3, 3};
  std::vector<dvec4> ctrl;
  for (int i = 0; i < 7 * 5; ++i) {
    const double w = weight(random);
    ctrl.emplace_back(w * dvec3(coordinate(random), coordinate(random), coordinate(random)), w);
  }
  std::vector<SurfaceForm> forms = {make_bspline(3, 2, ku, kv, ctrl)};
  for (const Named& n : analytic_forms()) forms.push_back(n.form);
  for (const SurfaceForm& form : forms) {
    NurbsStore store;
    const Surface& f = store.surfaces[append_surface(store, form)];
    const BezierPatches patches = bezier_patches(store, f);
    ASSERT_EQ(patches.uv_face.size(), std::size_t(patches.spans_u) * patches.spans_v);
    ASSERT_EQ(patches.ctrl_h.size(), patches.uv_face.size() * patches.points());
    for (std::size_t k = 0; k < patches.uv_face.size(); ++k) {
      const Box2& b = patches.uv_face[k];
      for (int i = 0; i < 20; ++i) {
        const dvec2 local(unit(random), unit(random));
        std::vector<dvec4> rows;
        for (int r = 0; r <= patches.degree_u; ++r)
          rows.push_back(bezier_point(&patches.ctrl_h[k * patches.points() + r * (patches.degree_v + 1)],
                                      patches.degree_v, local.y));
        const dvec3 p = project(bezier_point(rows.data(), patches.degree_u, local.x));
        const dvec2 uv(face_from_nurbs(store, f.knots_u, f.map_u, b.lower.x + local.x * b.extent().x),
                       face_from_nurbs(store, f.knots_v, f.map_v, b.lower.y + local.y * b.extent().y));
        EXPECT_LE(glm::distance(p, evaluate(store, f, uv).p), 1e-14 * largest(form));
      }
    }
  }
}

TEST(Surface, respanContinuesThePolynomial) {
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> coordinate(-5.0, 5.0), unit(0.0, 1.0);
  std::vector<dvec4> ctrl;
  for (int i = 0; i < 7 * 5; ++i)
    ctrl.emplace_back(coordinate(random), coordinate(random), coordinate(random), 1.0);
  const SurfaceForm whole =
      make_bspline(3, 2, {0, 0, 0, 0, 1, 1, 2.5, 4, 4, 4, 4}, {-1, -1, -1, 0.5, 1, 3, 3, 3}, ctrl);
  for (const Box2& domain :
       {Box2{{0.3, -0.2}, {3.7, 2.0}}, Box2{{-0.4, -1.2}, {4.5, 3.3}}, Box2{{1.2, 0.6}, {2.0, 0.9}},
        Box2{{1.0, 0.5}, {2.5, 1.0}}, Box2{{0.0, -1.0}, {4.0, 3.0}}}) {
    SurfaceForm part = whole;
    respan_surface(part, domain);
    EXPECT_EQ(part.surface.domain.lower, domain.lower);
    EXPECT_EQ(part.surface.domain.upper, domain.upper);
    for (int i = 0; i < 200; ++i) {
      const dvec2 uv = domain.lower + domain.extent() * dvec2(unit(random), unit(random));
      const SurfacePoint a = evaluate(view(whole), uv), b = evaluate(view(part), uv);
      EXPECT_LE(glm::distance(a.p, b.p), 2e-13);
      EXPECT_LE(glm::distance(a.du, b.du), 2e-12);
    }
  }
}

TEST(Surface, respanKeepsAccuracyOnVeryUnevenKnots) {
  // Eight steps on coordinates of 1e3 round by up to 1e-11. A span of 1e-4 beside spans of 1: found in a
  // turbine blade, where extrapolating from the short span lost every digit.
  SplineCurve<dvec4> c;
  c.degree = 8;
  c.knots.assign(9, 0.0);
  for (int i = 0; i < 20; ++i) c.knots.push_back(1e-4 + i);
  c.knots.insert(c.knots.end(), 9, 20.0);
  for (int i = 0; i < 29; ++i) c.ctrl.emplace_back(1e3 * std::cos(i), 1e3 * std::sin(2.0 * i), i, 1.0);
  const auto at = [](const SplineCurve<dvec4>& s, double t) {
    Basis b;
    const int span = find_span(s.knots, s.degree, t);
    basis_functions(s.knots, s.degree, span, t, 0, b);
    dvec4 p(0.0);
    for (int i = 0; i <= s.degree; ++i) p += b.value[0][i] * s.ctrl[span - s.degree + i];
    return project(p);
  };
  for (const dvec2 part : {dvec2(0.0, 20.0), dvec2(5e-5, 19.5), dvec2(2e-4, 1.0), dvec2(0.5, 19.9999)}) {
    const SplineCurve<dvec4> r = respan_curve(c, part.x, part.y);
    std::vector<dvec4> bezier;
    append_bezier<dvec4>(r.knots, r.degree, r.ctrl.data(), 1, bezier);
    const std::vector<double> k = distinct_knots(r.knots, r.degree);
    for (std::size_t span = 0; span + 1 < k.size(); ++span)
      for (double x = 0.0; x <= 1.0; x += 0.125) {
        const double t = k[span] + x * (k[span + 1] - k[span]);
        EXPECT_LE(glm::distance(at(c, t), at(r, t)), 1e-11) << t;
        EXPECT_LE(glm::distance(at(c, t), project(bezier_point(&bezier[span * 9], 8, x))), 1e-11) << t;
      }
  }
  EXPECT_EQ(respan_curve(c, 0.0, 20.0).ctrl, c.ctrl);  // nothing to do: bit-exact
}

TEST(Surface, periodicKnotsUnrollOverSeveralPeriods) {
  // A closed cubic of 5 poles, knots 0..5 simple: pole i is the same after every turn.
  const std::vector<double> knots = {0, 1, 2, 3, 4, 5};
  const std::vector<std::int32_t> simple(6, 1);
  std::vector<dvec4> poles;
  for (int i = 0; i < 5; ++i) poles.emplace_back(std::cos(i), std::sin(2.0 * i), i * i, 1.0);
  const auto curve = [&](double a, double b) {
    const FlatKnots flat = flatten_knots(knots, simple, 3, 5, true, a, b);
    SplineCurve<dvec4> c;
    c.degree = 3, c.knots = flat.knots;
    for (const int i : flat.wrap) c.ctrl.push_back(poles[i]);
    return respan_curve(c, a, b);
  };
  const auto at = [](const SplineCurve<dvec4>& c, double t) {
    Basis b;
    const int span = find_span(c.knots, 3, t);
    basis_functions(c.knots, 3, span, t, 0, b);
    dvec4 p(0.0);
    for (int i = 0; i < 4; ++i) p += b.value[0][i] * c.ctrl[span - 3 + i];
    return project(p);
  };
  // Independent: the uniform cubic's own matrix form at the middle of a span and at a knot.
  const SplineCurve<dvec4> wide = curve(-7.25, 9.5);
  for (int k = -7; k < 9; ++k) {
    const auto pole = [&](int i) { return dvec3(poles[((i % 5) + 5) % 5]); };
    const dvec3 knot = (pole(k) + 4.0 * pole(k + 1) + pole(k + 2)) / 6.0;
    EXPECT_LE(glm::distance(at(wide, k), knot), 1e-13) << k;
  }
  const SplineCurve<dvec4> narrow = curve(3.1, 3.2);
  EXPECT_EQ(narrow.ctrl.size(), 4u);
  EXPECT_LE(glm::distance(at(narrow, 3.15), at(wide, 3.15)), 1e-13);
  EXPECT_LE(glm::distance(at(narrow, 3.15), at(wide, 3.15 - 10.0)), 1e-13);
}
