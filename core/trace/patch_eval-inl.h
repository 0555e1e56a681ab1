// Evaluation of one Bezier patch at a parameter per lane. Included once per Highway target.
#if defined(TRIMRAY_CORE_TRACE_PATCH_EVAL_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef TRIMRAY_CORE_TRACE_PATCH_EVAL_INL_H_
#undef TRIMRAY_CORE_TRACE_PATCH_EVAL_INL_H_
#else
#define TRIMRAY_CORE_TRACE_PATCH_EVAL_INL_H_
#endif

#include "core/trace/vec3-inl.h"

HWY_BEFORE_NAMESPACE();
namespace trimray::HWY_NAMESPACE {

// Homogeneous point and first derivatives. The weights are set for rational forms only.
struct Jet {
  Vec3 p, pu, pv;
  Lanes w, wu, wv;
};

template <bool kRational>
struct Quad {
  Lanes c[kRational ? 4 : 3];
};

// Power basis in (u - 1/2, v - 1/2), Horner's rule in both directions. Degrees 0: known at run time only.
template <int kDegreeU, int kDegreeV, bool kIsRational>
struct PowerForm {
  static constexpr bool kRational = kIsRational;
  const double* coef;
  int degree_u = kDegreeU, degree_v = kDegreeV;

  HWY_INLINE Jet jet(Lanes u, Lanes v) const {
    constexpr int kDim = kRational ? 4 : 3;
    const int nu = kDegreeU ? kDegreeU : degree_u, nv = kDegreeV ? kDegreeV : degree_v;
    const Lanes s = u - Lanes(0.5), t = v - Lanes(0.5);
    Lanes f[kDim], fs[kDim], ft[kDim];
    for (int c = 0; c < kDim; ++c) f[c] = fs[c] = ft[c] = Lanes(0.0);
    for (int i = nu; i >= 0; --i) {
      const double* row = coef + i * (nv + 1) * 4;
      Lanes r[kDim], rt[kDim];
      // Degrees are at least 1: the first two coefficients of a row start both sums.
      for (int c = 0; c < kDim; ++c) {
        rt[c] = Lanes(row[nv * 4 + c]);
        r[c] = mul_add(rt[c], t, Lanes(row[(nv - 1) * 4 + c]));
      }
      for (int j = nv - 2; j >= 0; --j)
        for (int c = 0; c < kDim; ++c) {
          rt[c] = mul_add(rt[c], t, r[c]);
          r[c] = mul_add(r[c], t, Lanes(row[j * 4 + c]));
        }
      for (int c = 0; c < kDim; ++c) {
        if (i == nu) {
          f[c] = r[c], ft[c] = rt[c];
        } else {
          fs[c] = i == nu - 1 ? f[c] : mul_add(fs[c], s, f[c]);
          f[c] = mul_add(f[c], s, r[c]);
          ft[c] = mul_add(ft[c], s, rt[c]);
        }
      }
    }
    Jet j;
    j.p = {f[0], f[1], f[2]}, j.pu = {fs[0], fs[1], fs[2]}, j.pv = {ft[0], ft[1], ft[2]};
    if (kRational) j.w = f[kDim - 1], j.wu = fs[kDim - 1], j.wv = ft[kDim - 1];
    return j;
  }
};

// Bernstein basis, any degree: stable up to the highest.
struct BernsteinForm {
  static constexpr bool kRational = true;
  const double* coef;
  int degree_u, degree_v;
  static constexpr int kMaxCount = 31;

  // The n + 1 basis functions and their derivatives, by de Casteljau's recurrence.
  static HWY_INLINE void basis(int n, Lanes x, Lanes* value, Lanes* derivative) {
    const Lanes y = Lanes(1.0) - x;
    value[0] = Lanes(1.0);
    for (int r = 1; r < n; ++r) {
      value[r] = value[r - 1] * x;
      for (int i = r - 1; i >= 1; --i) value[i] = mul_add(value[i], y, value[i - 1] * x);
      value[0] = value[0] * y;
    }
    const Lanes degree(static_cast<double>(n));
    derivative[0] = Lanes(0.0) - value[0] * degree;
    for (int i = 1; i < n; ++i) derivative[i] = (value[i - 1] - value[i]) * degree;
    derivative[n] = value[n - 1] * degree;
    value[n] = value[n - 1] * x;
    for (int i = n - 1; i >= 1; --i) value[i] = mul_add(value[i], y, value[i - 1] * x);
    value[0] = value[0] * y;
  }

  HWY_INLINE Jet jet(Lanes u, Lanes v) const {
    Lanes bu[kMaxCount], du[kMaxCount], bv[kMaxCount], dv[kMaxCount];
    basis(degree_u, u, bu, du);
    basis(degree_v, v, bv, dv);
    Lanes f[4], fu[4], fv[4];
    for (int c = 0; c < 4; ++c) f[c] = fu[c] = fv[c] = Lanes(0.0);
    const double* p = coef;
    for (int i = 0; i <= degree_u; ++i) {
      Lanes r[4], rv[4];
      for (int c = 0; c < 4; ++c) r[c] = rv[c] = Lanes(0.0);
      for (int j = 0; j <= degree_v; ++j, p += 4)
        for (int c = 0; c < 4; ++c) {
          r[c] = mul_add(bv[j], Lanes(p[c]), r[c]);
          rv[c] = mul_add(dv[j], Lanes(p[c]), rv[c]);
        }
      for (int c = 0; c < 4; ++c) {
        f[c] = mul_add(bu[i], r[c], f[c]);
        fu[c] = mul_add(du[i], r[c], fu[c]);
        fv[c] = mul_add(bu[i], rv[c], fv[c]);
      }
    }
    return {{f[0], f[1], f[2]}, {fu[0], fu[1], fu[2]}, {fv[0], fv[1], fv[2]}, f[3], fu[3], fv[3]};
  }
};

}  // namespace trimray::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target guard
