//> Wrap the registers of a processor
// The compiler's vector types for the kernels, and the operations that have no operator. A kernel's source is
// compiled once for each instruction set; where a set has no instruction for an operation, a plain form
// stands in, so that the text compiles for every processor. Everything has internal linkage or is always
// inlined, and nothing of the C++ library is included: a function that two kernels shared could be linked in
// the form of either, for every caller.
#pragma once

#include <cstddef>
#include <cstdint>

#if defined(__SSE2__)
#include <immintrin.h>
#endif

namespace cuticle::lanes {
namespace {

#define CUTICLE_INLINE [[gnu::always_inline]] inline

//> Choose the registers
// Registers of n floats and of n whole numbers. A comparison yields whole numbers, -1 where it holds and else
// 0.
template <size_t n>
struct Pack {
    typedef float F __attribute__((vector_size(4 * n)));
    typedef int32_t I __attribute__((vector_size(4 * n)));
};

template <typename F>
CUTICLE_INLINE F Load(const float *p) {
    F v;
    __builtin_memcpy(&v, p, sizeof(v));
    return v;
}
// Loads whole numbers of 16 bits as floats.
template <typename F>
CUTICLE_INLINE F LoadSmall(const int16_t *p) {
    typedef int16_t Small __attribute__((vector_size(sizeof(F) / 2)));
    Small v;
    __builtin_memcpy(&v, p, sizeof(v));
    return __builtin_convertvector(v, F);
}
#if defined(__AVX2__)
template <>
CUTICLE_INLINE __m256 LoadSmall<__m256>(const int16_t *p) {
    return _mm256_cvtepi32_ps(_mm256_cvtepi16_epi32(_mm_loadu_si128(reinterpret_cast<const __m128i *>(p))));
}
#endif
#if defined(__AVX512F__)
template <>
CUTICLE_INLINE __m512 LoadSmall<__m512>(const int16_t *p) {
    // the forms without a mask warn of their own registers in g++ 12
    const __m256i v = _mm256_loadu_si256(reinterpret_cast<const __m256i *>(p));
    return _mm512_maskz_cvtepi32_ps(0xffff, _mm512_maskz_cvtepi16_epi32(0xffff, v));
}
#endif
// A register with x in every lane.
template <typename F>
CUTICLE_INLINE F Fill(float x) {
    return x - F{};
}
//<

//> Multiply pairs of whole numbers
// Multiplies each lane's two numbers of 16 bits with those of `pair` and adds the two products up.
template <typename I>
CUTICLE_INLINE I DotPairs(I pairs, int32_t pair) {
    if constexpr (false) {
    }
#if defined(__SSE2__)
    else if constexpr (sizeof(I) == 16)
        return reinterpret_cast<I>(_mm_madd_epi16(reinterpret_cast<__m128i>(pairs), _mm_set1_epi32(pair)));
#endif
#if defined(__AVX2__)
    else if constexpr (sizeof(I) == 32)
        return reinterpret_cast<I>(
            _mm256_madd_epi16(reinterpret_cast<__m256i>(pairs), _mm256_set1_epi32(pair)));
#endif
#if defined(__AVX512BW__)
    else if constexpr (sizeof(I) == 64)
        return reinterpret_cast<I>(
            _mm512_madd_epi16(reinterpret_cast<__m512i>(pairs), _mm512_set1_epi32(pair)));
#endif
    else
        return (pairs << 16 >> 16) * (pair << 16 >> 16) + (pairs >> 16) * (pair >> 16);
}
//<

//> Take minimum and maximum
template <typename F>
CUTICLE_INLINE F Min(F a, F b) {
    return a < b ? a : b;
}
template <typename F>
CUTICLE_INLINE F Max(F a, F b) {
    return a > b ? a : b;
}
//<

//> Turn masks into bits
// Returns one bit for each lane whose mask is set.
template <typename I>
CUTICLE_INLINE uint32_t Bits(I mask) {
    if constexpr (false) {
    }
#if defined(__SSE2__)
    else if constexpr (sizeof(I) == 16)
        return static_cast<uint32_t>(_mm_movemask_ps(reinterpret_cast<__m128>(mask)));
#endif
#if defined(__AVX__)
    else if constexpr (sizeof(I) == 32)
        return static_cast<uint32_t>(_mm256_movemask_ps(reinterpret_cast<__m256>(mask)));
#endif
#if defined(__AVX512F__)
    else if constexpr (sizeof(I) == 64)
        return _mm512_cmplt_epi32_mask(reinterpret_cast<__m512i>(mask), _mm512_setzero_si512());
#endif
    else {
        uint32_t bits = 0;
        for (unsigned i = 0; i < sizeof(I) / 4; ++i)
            bits |= (mask[i] != 0 ? 1u : 0u) << i;
        return bits;
    }
}
//<

//> Take minimum and maximum
#if defined(__SSE2__)
template <>
CUTICLE_INLINE __m128 Min(__m128 a, __m128 b) {
    return _mm_min_ps(a, b);
}
template <>
CUTICLE_INLINE __m128 Max(__m128 a, __m128 b) {
    return _mm_max_ps(a, b);
}
#endif
#if defined(__AVX__)
template <>
CUTICLE_INLINE __m256 Min(__m256 a, __m256 b) {
    return _mm256_min_ps(a, b);
}
template <>
CUTICLE_INLINE __m256 Max(__m256 a, __m256 b) {
    return _mm256_max_ps(a, b);
}
#endif
#if defined(__AVX512F__)
template <>
CUTICLE_INLINE __m512 Min(__m512 a, __m512 b) {
    return _mm512_maskz_min_ps(0xffff, a, b); // the form without a mask warns of its own register in g++ 12
}
template <>
CUTICLE_INLINE __m512 Max(__m512 a, __m512 b) {
    return _mm512_maskz_max_ps(0xffff, a, b);
}
#endif
//<

//> Take roots, sizes and sums, and choose
template <typename F>
CUTICLE_INLINE F Sqrt(F a) {
    if constexpr (false) {
    }
#if defined(__SSE2__)
    else if constexpr (sizeof(F) == 16)
        return _mm_sqrt_ps(a);
#endif
    else {
        for (size_t i = 0; i < sizeof(F) / 4; ++i)
            a[i] = __builtin_sqrtf(a[i]);
        return a;
    }
}
template <typename F>
CUTICLE_INLINE F Abs(F a) {
    using I = typename Pack<sizeof(F) / 4>::I;
    return reinterpret_cast<F>(reinterpret_cast<I>(a) & 0x7fffffff);
}
// In each lane yes where the mask is set, else no.
template <typename I, typename F>
CUTICLE_INLINE F Select(I mask, F yes, F no) {
    return mask ? yes : no;
}
// The sum of four lanes.
CUTICLE_INLINE float Sum(Pack<4>::F a) {
#if defined(__SSE3__)
    const __m128 pairs = _mm_hadd_ps(a, a);
    return _mm_cvtss_f32(_mm_hadd_ps(pairs, pairs));
#else
    return (a[0] + a[2]) + (a[1] + a[3]);
#endif
}
//<

} // namespace
} // namespace cuticle::lanes
//<
