// A pack of doubles: the same arithmetic on several lanes at once.
//
// A formula written over a scalar type T serves one point with T = double and W
// points with T = Pack<W, ...>. Each lane performs exactly the operations of a
// double in the same order, so results do not depend on the number of lanes.
// Every file that computes with packs is compiled without contraction of
// products and sums (cmake/KinegraphTargets.cmake) and must not use Eigen,
// whose alignment depends on the instruction set.
//
// Based on the vector types of GCC and Clang. Besides the operators there are,
// for packs and double alike:
//   Mask<T>                 bool, or a pack of them
//   Select(mask, a, b)      a where the mask is true, else b
//   Any(mask), All(mask)    over the lanes
//   And, Or, Not            of masks
//   Sqrt, Abs, Max          Max(a, b) is b where a is NaN
//   Log1p                   log(1 + a)
//   Atan                    the arc tangent of a, radians
// Packs also have sqrt and max, for templates that use std::sqrt and std::max.
#ifndef KINEGRAPH_CORE_BASE_PACK_H_
#define KINEGRAPH_CORE_BASE_PACK_H_

#include <cstdint>

namespace kinegraph {

#define KINEGRAPH_INLINE inline __attribute__((always_inline))

// Instruction sets as types: code compiled for one of them must not share a
// symbol with code compiled for another.
struct BaselineTarget {};
struct Avx2Target {};
struct Avx512Target {};

// The compiler's own vectors of W numbers.
template <int W>
struct VectorTypes;
template <>
struct VectorTypes<2> {
  typedef double Numbers __attribute__((vector_size(16)));
  typedef int64_t Bits __attribute__((vector_size(16)));
};
template <>
struct VectorTypes<4> {
  typedef double Numbers __attribute__((vector_size(32)));
  typedef int64_t Bits __attribute__((vector_size(32)));
};
template <>
struct VectorTypes<8> {
  typedef double Numbers __attribute__((vector_size(64)));
  typedef int64_t Bits __attribute__((vector_size(64)));
};

// True and false in W lanes, as all bits or none.
template <int W, typename Target>
struct PackMask {
  using Bits = typename VectorTypes<W>::Bits;
  Bits bits;
};

template <int W, typename Target>
struct Pack {
  using Vector = typename VectorTypes<W>::Numbers;
  static constexpr int kLanes = W;
  using MaskType = PackMask<W, Target>;

  Vector v;

  Pack() = default;
  // The same number in every lane.
  // NOLINTNEXTLINE(google-explicit-constructor): constants mix with packs.
  KINEGRAPH_INLINE Pack(double value) : v(value - Vector{}) {}
  KINEGRAPH_INLINE explicit Pack(Vector vector) : v(vector) {}

  // Loads and stores W numbers without alignment requirements.
  static KINEGRAPH_INLINE Pack Load(const double* from) {
    Pack pack;
    __builtin_memcpy(&pack.v, from, sizeof(Vector));
    return pack;
  }
  KINEGRAPH_INLINE void Store(double* to) const {
    __builtin_memcpy(to, &v, sizeof(Vector));
  }
  KINEGRAPH_INLINE double operator[](int lane) const { return v[lane]; }

  friend KINEGRAPH_INLINE Pack operator+(Pack a, Pack b) {
    return Pack(a.v + b.v);
  }
  friend KINEGRAPH_INLINE Pack operator-(Pack a, Pack b) {
    return Pack(a.v - b.v);
  }
  friend KINEGRAPH_INLINE Pack operator*(Pack a, Pack b) {
    return Pack(a.v * b.v);
  }
  friend KINEGRAPH_INLINE Pack operator/(Pack a, Pack b) {
    return Pack(a.v / b.v);
  }
  friend KINEGRAPH_INLINE Pack operator-(Pack a) { return Pack(-a.v); }
  KINEGRAPH_INLINE Pack& operator+=(Pack b) {
    v += b.v;
    return *this;
  }
  KINEGRAPH_INLINE Pack& operator-=(Pack b) {
    v -= b.v;
    return *this;
  }
  KINEGRAPH_INLINE Pack& operator*=(Pack b) {
    v *= b.v;
    return *this;
  }

  friend KINEGRAPH_INLINE MaskType operator<(Pack a, Pack b) {
    return {a.v < b.v};
  }
  friend KINEGRAPH_INLINE MaskType operator>(Pack a, Pack b) {
    return {a.v > b.v};
  }
  friend KINEGRAPH_INLINE MaskType operator<=(Pack a, Pack b) {
    return {a.v <= b.v};
  }
  friend KINEGRAPH_INLINE MaskType operator>=(Pack a, Pack b) {
    return {a.v >= b.v};
  }
  friend KINEGRAPH_INLINE MaskType operator==(Pack a, Pack b) {
    return {a.v == b.v};
  }

  friend KINEGRAPH_INLINE Pack Select(MaskType mask, Pack a, Pack b) {
    return Pack(mask.bits ? a.v : b.v);
  }
  friend KINEGRAPH_INLINE Pack Sqrt(Pack a) {
    Pack root;
    for (int i = 0; i < W; ++i) root.v[i] = __builtin_sqrt(a.v[i]);
    return root;
  }
  friend KINEGRAPH_INLINE Pack Abs(Pack a) {
    using Bits = typename MaskType::Bits;
    return Pack((Vector)((Bits)a.v & INT64_MAX));
  }
  friend KINEGRAPH_INLINE Pack Max(Pack a, Pack b) {
    return Pack(a.v > b.v ? a.v : b.v);
  }
  friend KINEGRAPH_INLINE Pack Log1p(Pack a) {
    Pack log;
    for (int i = 0; i < W; ++i) log.v[i] = __builtin_log1p(a.v[i]);
    return log;
  }
  friend KINEGRAPH_INLINE Pack Atan(Pack a) {
    Pack angle;
    for (int i = 0; i < W; ++i) angle.v[i] = __builtin_atan(a.v[i]);
    return angle;
  }
  friend KINEGRAPH_INLINE Pack sqrt(Pack a) { return Sqrt(a); }
  friend KINEGRAPH_INLINE Pack max(Pack a, Pack b) { return Max(a, b); }
};

template <int W, typename Target>
KINEGRAPH_INLINE PackMask<W, Target> And(PackMask<W, Target> a,
                                         PackMask<W, Target> b) {
  return {a.bits & b.bits};
}
template <int W, typename Target>
KINEGRAPH_INLINE PackMask<W, Target> Or(PackMask<W, Target> a,
                                        PackMask<W, Target> b) {
  return {a.bits | b.bits};
}
template <int W, typename Target>
KINEGRAPH_INLINE PackMask<W, Target> Not(PackMask<W, Target> a) {
  return {~a.bits};
}
template <int W, typename Target>
KINEGRAPH_INLINE bool Any(PackMask<W, Target> mask) {
  int64_t any = 0;
  for (int i = 0; i < W; ++i) any |= mask.bits[i];
  return any != 0;
}
template <int W, typename Target>
KINEGRAPH_INLINE bool All(PackMask<W, Target> mask) {
  int64_t all = -1;
  for (int i = 0; i < W; ++i) all &= mask.bits[i];
  return all != 0;
}

// The same functions for a single number.
KINEGRAPH_INLINE double Select(bool mask, double a, double b) {
  return mask ? a : b;
}
KINEGRAPH_INLINE double Sqrt(double a) { return __builtin_sqrt(a); }
KINEGRAPH_INLINE double Abs(double a) { return __builtin_fabs(a); }
KINEGRAPH_INLINE double Max(double a, double b) { return a > b ? a : b; }
KINEGRAPH_INLINE double Log1p(double a) { return __builtin_log1p(a); }
KINEGRAPH_INLINE double Atan(double a) { return __builtin_atan(a); }
KINEGRAPH_INLINE bool And(bool a, bool b) { return a && b; }
KINEGRAPH_INLINE bool Or(bool a, bool b) { return a || b; }
KINEGRAPH_INLINE bool Not(bool a) { return !a; }
KINEGRAPH_INLINE bool Any(bool mask) { return mask; }
KINEGRAPH_INLINE bool All(bool mask) { return mask; }

// The result type of a comparison of two T.
template <typename T>
using Mask = decltype(T() < T());

// Packs as wide as the registers of each instruction set.
using BaselinePack = Pack<2, BaselineTarget>;
using Avx2Pack = Pack<4, Avx2Target>;
using Avx512Pack = Pack<8, Avx512Target>;

// Arrays of structure-of-arrays kernels have a multiple of this many lanes.
inline constexpr int kLaneMultiple = 8;
constexpr int PaddedLanes(int count) {
  return (count + kLaneMultiple - 1) / kLaneMultiple * kLaneMultiple;
}

}  // namespace kinegraph

#endif  // KINEGRAPH_CORE_BASE_PACK_H_
