// Proximal problem (10) of an isotropic energy in its three stretches, one element per lane:
//   minimise psi(s) + k/2 |s - sigma|^2 over s > 0
// by Newton's method with a clamped factorisation and backtracking. Included once per instruction set.
#include <hwy/highway.h>

#if defined(TISSUED_CORE_STRETCH_NEWTON_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef TISSUED_CORE_STRETCH_NEWTON_INL
#undef TISSUED_CORE_STRETCH_NEWTON_INL
#else
#define TISSUED_CORE_STRETCH_NEWTON_INL
#endif

HWY_BEFORE_NAMESPACE();
namespace tissued::core::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// J^(-1/3) for J > 0: a guess from the exponent bits of the float, then three third-order steps.
template <class D, class V = hn::Vec<D>>
HWY_INLINE V inverse_cube_root(D d, V j) {
  const hn::Rebind<float, D> df;
  const hn::RebindToSigned<decltype(df)> di;
  const auto bits = hn::ConvertTo(df, hn::BitCast(di, hn::DemoteTo(df, j)));
  const auto guess = hn::ConvertTo(di, hn::MulAdd(bits, hn::Set(df, -1.0f / 3.0f), hn::Set(df, 1419967116.0f)));
  V y = hn::PromoteTo(d, hn::BitCast(df, guess));
  for (int i = 0; i < 3; ++i) {
    const V h = hn::NegMulAdd(j * y, y * y, hn::Set(d, 1.0));
    y = hn::MulAdd(y * h, hn::MulAdd(h, hn::Set(d, 2.0 / 9.0), hn::Set(d, 1.0 / 3.0)), y);
  }
  return y;
}

// Equation (11), J = det F: psi = mu/2 (J^(-2/3) |s|^2 - 3) + kappa/2 (J - 1)^2.
template <class V>
struct NeoHookeanStretch {
  V shear_modulus, bulk_modulus;

  template <class D>
  struct Point {
    V j, inverse_j, alpha, trace, value;  // alpha = mu J^(-2/3); trace = |s|^2; value = psi + 3/2 mu
  };

  template <class D>
  HWY_INLINE Point<D> at(D d, const V s[3]) const {
    Point<D> p;
    const V one = hn::Set(d, 1.0), half = hn::Set(d, 0.5);
    p.j = s[0] * s[1] * s[2];
    p.inverse_j = one / p.j;
    const V root = inverse_cube_root(d, p.j);
    p.alpha = shear_modulus * root * root;
    p.trace = hn::MulAdd(s[2], s[2], hn::MulAdd(s[1], s[1], s[0] * s[0]));
    const V dilation = p.j - one;
    p.value = half * hn::MulAdd(p.alpha, p.trace, bulk_modulus * dilation * dilation);
    return p;
  }

  // gradient (3) and Hessian (00, 01, 02, 11, 12, 22).
  template <class D>
  HWY_INLINE void derivatives(D d, const V s[3], const Point<D>& p, V gradient[3], V hessian[6]) const {
    const V third = hn::Set(d, 1.0 / 3.0), two_thirds = hn::Set(d, 2.0 / 3.0);
    const V t[3] = {s[1] * s[2] * p.inverse_j, s[0] * s[2] * p.inverse_j, s[0] * s[1] * p.inverse_j};  // 1 / s
    const V deviator = p.alpha * p.trace * third;
    const V pressure = bulk_modulus * (p.j * p.j - p.j);
    const V radial = pressure - deviator;
    const V coupling = hn::MulAdd(two_thirds, deviator, bulk_modulus * p.j * p.j + pressure);
    for (int i = 0; i < 3; ++i) gradient[i] = hn::MulAdd(p.alpha, s[i], radial * t[i]);
    int entry = 0;
    for (int i = 0; i < 3; ++i) {
      for (int k = i; k < 3; ++k) {
        const V mixed = hn::MulAdd(s[i], t[k], s[k] * t[i]);
        V h = hn::NegMulAdd(two_thirds * p.alpha, mixed, coupling * t[i] * t[k]);
        if (i == k) h = h + hn::NegMulAdd(radial * t[i], t[i], p.alpha);
        hessian[entry++] = h;
      }
    }
  }
};
template <class V>
NeoHookeanStretch(V, V) -> NeoHookeanStretch<V>;

// Solves H x = -g by LDL^T; pivots below `floor` are raised to it, so that the direction descends.
template <class V>
HWY_INLINE void newton_direction(V floor, const V h[6], const V g[3], V x[3]) {
  const V d0 = hn::Max(h[0], floor);
  const V l10 = h[1] / d0, l20 = h[2] / d0;
  const V d1 = hn::Max(hn::NegMulAdd(l10, h[1], h[3]), floor);
  const V e21 = hn::NegMulAdd(l20, h[1], h[4]);
  const V l21 = e21 / d1;
  const V d2 = hn::Max(hn::NegMulAdd(l21, e21, hn::NegMulAdd(l20, h[2], h[5])), floor);
  const V y0 = hn::Neg(g[0]);
  const V y1 = hn::NegMulAdd(l10, y0, hn::Neg(g[1]));
  const V y2 = hn::NegMulAdd(l21, y1, hn::NegMulAdd(l20, y0, hn::Neg(g[2])));
  x[2] = y2 / d2;
  x[1] = hn::NegMulAdd(l21, x[2], y1 / d1);
  x[0] = hn::NegMulAdd(l20, x[2], hn::NegMulAdd(l10, x[1], y0 / d0));
}

// s: warm start in, minimiser out. Returns how many lanes did not converge.
template <class D, class Energy, class V = hn::Vec<D>>
HWY_INLINE int minimise_stretches(D d, const Energy& energy, V k, const V sigma[3], V s[3]) {
  constexpr int kNewtonLimit = 30, kBacktrackLimit = 20;
  const V one = hn::Set(d, 1.0), half = hn::Set(d, 0.5), zero = hn::Zero(d);
  const V enough = hn::Set(d, 1e-5);  // the step; the error after it is about its square
  const V floor = hn::Set(d, 0.05) * k;
  const auto objective = [&](const auto& point, const V at[3]) {
    V distance = zero;
    for (int i = 0; i < 3; ++i) distance = hn::MulAdd(at[i] - sigma[i], at[i] - sigma[i], distance);
    return hn::MulAdd(half * k, distance, point.value);
  };
  for (int i = 0; i < 3; ++i) s[i] = hn::Min(hn::Max(s[i], hn::Set(d, 1e-3)), hn::Set(d, 1e3));
  auto point = energy.at(d, s);
  V value = objective(point, s);
  for (int iteration = 0; iteration < kNewtonLimit; ++iteration) {
    V gradient[3], hessian[6], direction[3];
    energy.derivatives(d, s, point, gradient, hessian);
    for (int i = 0; i < 3; ++i) gradient[i] = hn::MulAdd(k, s[i] - sigma[i], gradient[i]);
    hessian[0] = hessian[0] + k;
    hessian[3] = hessian[3] + k;
    hessian[5] = hessian[5] + k;
    newton_direction(floor, hessian, gradient, direction);
    // Stretches stay positive: at most four fifths of the way to zero.
    V step = one, largest = zero;
    for (int i = 0; i < 3; ++i) {
      const V reach = hn::Set(d, 0.8) * s[i] / hn::Max(hn::Neg(direction[i]), hn::Set(d, 1e-100));
      step = hn::Min(step, hn::IfThenElse(direction[i] < zero, reach, one));
      largest = hn::Max(largest, hn::Abs(direction[i]));
    }
    const auto done = largest < enough;
    const V slack = hn::Set(d, 1e-13) * (hn::Abs(value) + k);
    V trial[3];
    for (int backtrack = 0;; ++backtrack) {
      for (int i = 0; i < 3; ++i) trial[i] = hn::MulAdd(step, direction[i], s[i]);
      point = energy.at(d, trial);
      const V trial_value = objective(point, trial);
      const auto accepted = hn::Or(trial_value <= value + slack, done);
      if (hn::AllTrue(d, accepted) || backtrack == kBacktrackLimit) {
        value = trial_value;
        break;
      }
      step = hn::IfThenElse(accepted, step, hn::Set(d, 0.3) * step);
    }
    for (int i = 0; i < 3; ++i) s[i] = trial[i];
    if (hn::AllTrue(d, done)) return 0;
    if (iteration + 1 == kNewtonLimit) return static_cast<int>(hn::CountTrue(d, hn::Not(done)));
  }
  return 0;
}

}  // namespace tissued::core::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
