// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// The kernels of quantised gradient orientations with OpenCV's universal intrinsics, row by row: a row of every stage stays in
// the first-level cache until the next stage has used it. namespace plain in qgo.cpp is the definition.

#include "opencv2/core/hal/intrin.hpp"
#include "detect/qgo.hpp"
#if CV_SIMD && !defined(CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY)
#include "base/simd.hpp"
#endif

namespace cv { namespace surgtrack {

CV_CPU_OPTIMIZATION_NAMESPACE_BEGIN

void quantizeKernel(const Mat& image, const Rect& window, int leastStrength, Mat& orientations, Mat* sizes, std::vector<uchar>& workspace);
void dropWeakKernel(uchar* bits, const uchar* sizes, const uchar* least, int n);
void spreadKernel(const Mat& src, Mat& dst, int size, std::vector<uchar>& workspace);
void responseKernel(const uchar* bits, size_t bitsStep, Size size, uchar* planes, size_t planeStep, size_t planeSize);
void similarityKernel(const uchar* planes, size_t step, const int* offsets, int features, Size window, ushort* sums);
void coarseKernel(const Mat& spread, Point tl, Size cells, uchar* planes, size_t planeStep, size_t planeSize, std::vector<uchar>& workspace);
int greatestKernel(const ushort* values, int n);
int atLeastKernel(const ushort* values, int n, int least, int* indices);
void cellKernel(const uchar* bits, size_t step, const CellFeature* features, int n, ushort* sums);

#ifndef CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

namespace {

#if CV_SIMD

// 16-bit sums here never reach saturation; 8-bit sums have a bound of their own below.

const int slack = 256;   // bytes that a row may be overrun by: three vectors of 64

void deinterleave(const uchar* src, int n, uchar* const* planes)
{
    for (int i = 0; i < n; i += lanes<v_uint8>())
    {
        v_uint8 a, b, c;
        v_load_deinterleave(src + 3 * i, a, b, c);
        v_store(planes[0] + i, a);
        v_store(planes[1] + i, b);
        v_store(planes[2] + i, c);
    }
}

template <typename V> inline V binomial(const V& a, const V& b, const V& c)
{
    return add(add(a, c), add(b, b));
}

// first * the even pixel + second * the odd one, of every two; weights are less than 128.
template <int first, int second> inline v_uint16 weightedPairs(const v_uint8& pixels)
{
#if CV_SIMD512 && CV_AVX512_SKX
    return v_uint16(_mm512_maddubs_epi16(pixels.val, _mm512_set1_epi16(first | second << 8)));
#elif CV_SIMD_WIDTH == 32 && CV_AVX2
    return v_uint16(_mm256_maddubs_epi16(pixels.val, _mm256_set1_epi16(first | second << 8)));
#elif CV_SIMD_WIDTH == 16 && CV_SSSE3
    return v_uint16(_mm_maddubs_epi16(pixels.val, _mm_set1_epi16(first | second << 8)));
#else
    const v_uint16 pairs = v_reinterpret_as_u16(pixels);
    return add(v_mul_wrap(band(pairs, vx_setall_u16(255)), vx_setall_u16(first)), v_mul_wrap(v_shr<8>(pairs), vx_setall_u16(second)));
#endif
}

/* The last rows of a channel. 16-bit rows hold the even pixels first, then, from half on, the odd ones. The next row replaces
   the older one of two. */
struct Rows
{
    short *across[2];             // [1 4 7 8 7 4 1]
    short *spaced[2], *third[2];  // and [1 0 1] down; and [1 2 1]
    short *blurred[2];            // and [1 2 1]
    short *smooth, *difference;   // [1 2 1] and [-1 0 1] down three rows of blurred: what is left to do of Sobel is across
};

inline void blurAndDifference(const v_uint16& sum, int i, int now, const Rows& rows)
{
    const int last = 1 - now;
    const v_int16 across = v_reinterpret_as_s16(v_shr<3>(add(sum, vx_setall_u16(4)))), spaced = add(vx_load(rows.across[now] + i), across);
    const v_int16 third = binomial(vx_load(rows.spaced[now] + i), vx_load(rows.spaced[last] + i), spaced);
    const v_int16 blurred = v_shr<3>(add(binomial(vx_load(rows.third[now] + i), vx_load(rows.third[last] + i), third), vx_setall_s16(4)));
    const v_int16 above = vx_load(rows.blurred[now] + i);
    v_store(rows.across[now] + i, across);
    v_store(rows.spaced[now] + i, spaced);
    v_store(rows.third[now] + i, third);
    v_store(rows.smooth + i, binomial(above, vx_load(rows.blurred[last] + i), blurred));
    v_store(rows.difference + i, sub(blurred, above));
    v_store(rows.blurred[now] + i, blurred);
}

// A row of pixels, which holds three more on either side, comes in; may overrun.
void blurAndDifference(const uchar* pixels, int n, int half, int now, const Rows& rows_)
{
    const Rows rows = rows_;
    for (int i = 0; 2 * i < n; i += lanes<v_int16>())
    {
        const uchar* p = pixels + 2 * i;
        const v_uint8 p0 = vx_load(p), p2 = vx_load(p + 2), p4 = vx_load(p + 4), p6 = vx_load(p + 6);
        blurAndDifference(add(add(weightedPairs<1, 4>(p0), weightedPairs<7, 8>(p2)), add(weightedPairs<7, 4>(p4), weightedPairs<1, 0>(p6))), i, now, rows);
        blurAndDifference(add(add(weightedPairs<0, 1>(p0), weightedPairs<4, 7>(p2)), add(weightedPairs<8, 7>(p4), weightedPairs<4, 1>(p6))), half + i, now, rows);
    }
}

inline v_int16 choose(const v_int16& mask, const v_int16& a, const v_int16& b)
{
    return bxor(b, band(mask, bxor(a, b)));
}

struct Gradient
{
    // From the columns of smooth beside the pixel, and the three of difference.
    inline void set(const v_int16& left, const v_int16& right, const v_int16& d0, const v_int16& d1, const v_int16& d2)
    {
        x = sub(right, left);
        y = binomial(d0, d1, d2);
    }
    inline v_int16 size() const { return v_reinterpret_as_s16(add(v_abs(x), v_abs(y))); }
    inline void replaceIf(const v_int16& mask, const Gradient& other)
    {
        x = choose(mask, other.x, x);
        y = choose(mask, other.y, y);
    }

    v_int16 x, y;
};

// The strongest of three, the first of equal ones.
inline const Gradient& strongest(Gradient* g)
{
    const v_int16 s0 = g[0].size(), s1 = g[1].size(), s2 = g[2].size();
    g[0].replaceIf(greater(s1, s0), g[1]);
    g[0].replaceIf(greater(s2, v_max(s0, s1)), g[2]);
    return g[0];
}

inline v_int16 times2(const v_int16& a) { return add(a, a); }

/* One bit for the direction of a gradient modulo 180 degrees, and whether it is strong; see plain::orientationBin(). 4 * 7690
   is less than 2^15, 5 * 7690 is not: 5 a > b is asked as 4 a > b - a. */
inline void orient(const Gradient& g, const v_int16& belowStrength, v_int16& bit, v_int16& strong)
{
    const v_uint16 ux = v_abs(g.x), uy = v_abs(g.y);
    const v_int16 ax = v_reinterpret_as_s16(ux), ay = v_reinterpret_as_s16(uy);
    const v_uint16 ux4 = v_shl<2>(ux), uy4 = v_shl<2>(uy);
    const v_int16 flatter = sub(ax, ay), steeper = sub(ay, ax);
    const v_int16 m1 = greater(v_reinterpret_as_s16(uy4), flatter), m2 = greater(ay, times2(flatter));
    const v_int16 m3 = greater(times2(steeper), ax), m4 = greater(steeper, v_reinterpret_as_s16(ux4));
    const v_int16 opposite = greater(vx_setzero_s16(), bxor(g.x, g.y));
    // Each mask implies those before it: 1, 2, 4, 8, 16 if the signs agree, else 1, 128, 64, 32, 16.
    const v_int16 to1 = bxor(vx_setall_s16(1 ^ 2), band(opposite, vx_setall_s16(2 ^ 128)));
    const v_int16 to2 = bxor(vx_setall_s16(4 ^ 2), band(opposite, vx_setall_s16(4 ^ 2 ^ 128 ^ 64)));
    const v_int16 to3 = bxor(vx_setall_s16(4 ^ 8), band(opposite, vx_setall_s16(4 ^ 8 ^ 64 ^ 32)));
    const v_int16 to4 = bxor(vx_setall_s16(8 ^ 16), band(opposite, vx_setall_s16(8 ^ 32)));
    bit = bxor(bxor(bxor(vx_setall_s16(1), band(m1, to1)), bxor(band(m2, to2), band(m3, to3))), band(m4, to4));
    strong = greater(v_reinterpret_as_s16(add(v_mul_hi(ux4, ux4), v_mul_hi(uy4, uy4))), belowStrength);
}

inline v_uint8 interleave(const v_int16& even, const v_int16& odd)
{
    return v_reinterpret_as_u8(bor(band(even, vx_setall_s16(255)), v_shl<8>(odd)));
}

// See plain::byteSize().
inline v_int16 byteSize(const Gradient& g)
{
    const v_uint16 x = v_abs(g.x), y = v_abs(g.y), less = v_min(x, y);
    const v_uint16 size = add(v_max(x, y), v_shr<3>(add(less, add(less, less))));
    return v_reinterpret_as_s16(v_min(v_shr<3>(size), vx_setall_u16(255)));
}

// Bits and strength of a row, and, if asked for, its sizes; may overrun.
void orientRow(const Rows* rows, int channels, int n, int half, int leastStrength, uchar* bits, uchar* strong, uchar* sizes)
{
    const v_int16 belowStrength = vx_setall_s16(short(leastStrength - 1));
    for (int i = 0; 2 * i < n; i += lanes<v_int16>())
    {
        Gradient even[3], odd[3];
        for (int c = 0; c < channels; c++)
        {
            const short *t = rows[c].smooth + i, *d = rows[c].difference + i;
            const v_int16 d0 = vx_load(d), d1 = vx_load(d + half), d2 = vx_load(d + 1), d3 = vx_load(d + half + 1);
            even[c].set(vx_load(t), vx_load(t + 1), d0, d1, d2);
            odd[c].set(vx_load(t + half), vx_load(t + half + 1), d1, d2, d3);
        }
        v_int16 bit[2], mask[2];
        const Gradient &g0 = channels == 3 ? strongest(even) : even[0], &g1 = channels == 3 ? strongest(odd) : odd[0];
        orient(g0, belowStrength, bit[0], mask[0]);
        orient(g1, belowStrength, bit[1], mask[1]);
        if (sizes) v_store(sizes + 2 * i, interleave(byteSize(g0), byteSize(g1)));
        v_store(bits + 2 * i, interleave(bit[0], bit[1]));
        v_store(strong + 2 * i, interleave(mask[0], mask[1]));
    }
}

inline v_uint8 majority(const v_uint8& a, const v_uint8& b, const v_uint8& c)
{
    return bor(band(a, b), band(c, bxor(a, b)));
}

// Counts, for all eight bits at once, how many of the nine pixels have a bit: two adders of one-bit numbers down the columns,
// then across them. A bit with five votes or more stays where the gradient is strong.
void vote(const uchar* above, const uchar* row, const uchar* below, const uchar* strong, int n, uchar* ones, uchar* twos, uchar* dst)
{
    const int step = lanes<v_uint8>();
    for (int i = 0; i < n + 2; i += step)
    {
        const v_uint8 a = vx_load(above + i), b = vx_load(row + i), c = vx_load(below + i);
        v_store(ones + i, bxor(bxor(a, b), c));
        v_store(twos + i, majority(a, b, c));
    }
    for (int i = 0; i < n; i += step)
    {
        const v_uint8 s0 = vx_load(ones + i), s1 = vx_load(ones + i + 1), s2 = vx_load(ones + i + 2);
        const v_uint8 c0 = vx_load(twos + i), c1 = vx_load(twos + i + 1), c2 = vx_load(twos + i + 2);
        const v_uint8 t0 = bxor(bxor(s0, s1), s2), k0 = majority(s0, s1, s2);      // of weight 1; carry
        const v_uint8 u = bxor(bxor(c0, c1), c2), v = majority(c0, c1, c2);        // of weight 2; carry
        const v_uint8 t1 = bxor(u, k0), k1 = band(u, k0);
        const v_uint8 t2 = bxor(v, k1), t3 = band(v, k1);                          // of weight 4 and 8
        const v_uint8 fiveOrMore = bor(t3, band(t2, bor(t0, t1)));
        v_store(dst + i, band(fiveOrMore, vx_load(strong + i + 1)));
    }
}

template <typename T> T* take(uchar*& memory, size_t count)
{
    T* p = reinterpret_cast<T*>(memory);
    memory += (count * sizeof(T) + slack + 63) & ~size_t(63);
    return p;
}

#endif   // CV_SIMD

} // namespace

#if CV_SIMD
// A window as wide as the first-level cache has room for its rows.
static void quantizeStrip(const Mat& image, const Rect& window, int leastStrength, Mat& orientations, Mat* sizes, int x, std::vector<uchar>& workspace)
{
    const int c = image.channels(), w = window.width, h = window.height;
    const int x0 = window.x - 5, n = w + 10;                                     // columns needed, some beyond the image
    const int inside0 = std::max(x0, 0), inside1 = std::min(x0 + n, image.cols);
    const int half = (n / 2 + slack / 2) & ~31;
    const size_t bytes = (2 * size_t(n) + 10 * sizeof(short) * 2 * half) * c + 10 * size_t(n) + (1 + 11 * c + 10) * 2 * slack;
    if (workspace.size() < bytes) workspace.resize(bytes);
    uchar* memory = alignPtr(&workspace[0], 64);
    uchar* row = take<uchar>(memory, size_t(n) * c);
    uchar *planes[3] = {row, 0, 0}, *bits[3], *strong[2], *size[2];
    Rows rows[3];
    for (int i = 0; i < c; i++)
    {
        if (c > 1) planes[i] = take<uchar>(memory, n);
        for (int j = 0; j < 2; j++)
        {
            rows[i].across[j] = take<short>(memory, 2 * half);
            rows[i].spaced[j] = take<short>(memory, 2 * half);
            rows[i].third[j] = take<short>(memory, 2 * half);
            rows[i].blurred[j] = take<short>(memory, 2 * half);
        }
        rows[i].smooth = take<short>(memory, 2 * half);
        rows[i].difference = take<short>(memory, 2 * half);
    }
    for (int i = 0; i < 3; i++) bits[i] = take<uchar>(memory, n);
    for (int i = 0; i < 2; i++)
    {
        strong[i] = take<uchar>(memory, n);
        size[i] = take<uchar>(memory, n);
    }
    uchar *ones = take<uchar>(memory, n), *twos = take<uchar>(memory, n), *voted = take<uchar>(memory, n);

    // Row y of the window needs bits of y - 1 .. y + 1, blurred rows of y - 2 .. y + 2, image rows of y - 5 .. y + 5.
    for (int y = -5; y < h + 5; y++)
    {
        const uchar* source = image.ptr(std::min(std::max(window.y + y, 0), image.rows - 1));
        std::copy(source + inside0 * c, source + inside1 * c, row + (inside0 - x0) * c);
        for (int i = (inside0 - x0) * c - 1; i >= 0; i--) row[i] = row[i + c];
        for (int i = (inside1 - x0) * c; i < n * c; i++) row[i] = row[i - c];
        if (c == 3) deinterleave(row, n, planes);
        for (int i = 0; i < c; i++) blurAndDifference(planes[i], w + 4, half, y & 1, rows[i]);
        if (y < 3) continue;
        // blurred rows y - 5, y - 4, y - 3 are there: bits of row y - 4
        orientRow(rows, c, w + 2, half, leastStrength, bits[y % 3], strong[y % 2], sizes ? size[y % 2] : 0);
        if (y < 5) continue;
        // bits of rows y - 6, y - 5, y - 4: row y - 5 of the result
        vote(bits[(y + 1) % 3], bits[(y + 2) % 3], bits[y % 3], strong[(y + 1) % 2], w, ones, twos, voted);
        std::copy(voted, voted + w, orientations.ptr(y - 5) + x);
        if (sizes) std::copy(size[(y + 1) % 2] + 1, size[(y + 1) % 2] + 1 + w, sizes->ptr(y - 5) + x);
    }
}
#endif

void quantizeKernel(const Mat& image, const Rect& window, int leastStrength, Mat& orientations, Mat* sizes, std::vector<uchar>& workspace)
{
#if CV_SIMD
    const int strips = (window.width + 379) / 380, width = (window.width + strips - 1) / strips;
    for (int x = 0; x < window.width; x += width)
        quantizeStrip(image, Rect(window.x + x, window.y, std::min(width, window.width - x), window.height), leastStrength, orientations, sizes, x, workspace);
#else
    CV_UNUSED(workspace);
    plain::quantize(image, window, leastStrength, orientations, sizes);
#endif
}

void dropWeakKernel(uchar* bits, const uchar* sizes, const uchar* least, int n)
{
    int i = 0;
#if CV_SIMD
    for (; i <= n - lanes<v_uint8>(); i += lanes<v_uint8>())
    {
        const v_uint8 size = vx_load(sizes + i);
        v_store(bits + i, band(vx_load(bits + i), equal(v_max(size, vx_load(least + i)), size)));
    }
#endif
    for (; i < n; i++)
        if (sizes[i] < least[i]) bits[i] = 0;
}

void spreadKernel(const Mat& src, Mat& dst, int size, std::vector<uchar>& workspace)
{
#if CV_SIMD
    const int r = size / 2, w = src.cols, h = src.rows, step = lanes<v_uint8>();
    // A row, OR-ed down its columns, with r empty pixels on either side.
    const size_t bytes = size_t(w) + 2 * r + 4 * slack;
    if (workspace.size() < bytes) workspace.resize(bytes);
    uchar* column = alignPtr(&workspace[0], slack);
    std::fill(column, column + r, uchar(0));
    std::fill(column + r + w, column + w + 2 * r + 2 * slack, uchar(0));
    for (int y = 0; y < h; y++)
    {
        const int top = std::max(0, y - r), bottom = std::min(h - 1, y + r);
        int x = 0;
        for (; x <= w - step; x += step)
        {
            v_uint8 bits = vx_load(src.ptr(top) + x);
            for (int j = top + 1; j <= bottom; j++) bits = bor(bits, vx_load(src.ptr(j) + x));
            v_store(column + r + x, bits);
        }
        for (; x < w; x++)
        {
            uchar bits = 0;
            for (int j = top; j <= bottom; j++) bits |= src.ptr(j)[x];
            column[r + x] = bits;
        }
        uchar* out = dst.ptr(y);
        for (x = 0; x <= w - step; x += step)
        {
            v_uint8 bits = vx_load(column + x);
            for (int i = 1; i < size; i++) bits = bor(bits, vx_load(column + x + i));
            v_store(out + x, bits);
        }
        for (; x < w; x++)
        {
            uchar bits = 0;
            for (int i = 0; i < size; i++) bits |= column[x + i];
            out[x] = bits;
        }
    }
#else
    CV_UNUSED(workspace);
    plain::spread(src, dst, size);
#endif
}

// All eight response maps; bin b of a row is at planes + b * planeSize. Rows may be overrun.
void responseKernel(const uchar* bits, size_t bitsStep, Size size, uchar* planes, size_t planeStep, size_t planeSize)
{
    for (int y = 0; y < size.height; y++)
    {
        const uchar* src = bits + y * bitsStep;
        uchar* dst = planes + y * planeStep;
        int x = 0;
#if CV_SIMD
        const int step = lanes<v_uint8>();
        const v_uint8 one = vx_setall_u8(1);
        for (; x <= size.width - step; x += step)
        {
            const v_uint8 b = vx_load(src + x);
            for (int bin = 0; bin < 8; bin++)
            {
                // 3 for the orientation itself, and 1 for it or a neighbour
                const int same = 1 << bin, wide = same | 1 << ((bin + 1) & 7) | 1 << ((bin + 7) & 7);
                const v_uint8 exact = v_min(band(b, vx_setall_u8(uchar(same))), one);
                v_store(dst + bin * planeSize + x, add(add(v_min(band(b, vx_setall_u8(uchar(wide))), one), exact), add(exact, exact)));
            }
        }
#endif
        for (; x < size.width; x++)
            for (int bin = 0; bin < 8; bin++)
            {
                const int same = 1 << bin, next = 1 << ((bin + 1) & 7) | 1 << ((bin + 7) & 7);
                dst[bin * planeSize + x] = src[x] & same ? 4 : src[x] & next ? 1 : 0;
            }
    }
}

/* Sums the responses of a template's features for every place of a window: sums(y, x) = sum over i of
   planes[offsets[i] + y * step + x]. Responses are at most 4, so 63 of them fit into 8 bits: 63 * 4 = 252. Four rows at a time
   share the loads of offsets; at the end some are the last one again. Reads up to a vector beyond the end of each row. */
void similarityKernel(const uchar* planes, size_t step, const int* offsets, int features, Size window, ushort* sums)
{
    for (int y = 0; y < window.height; y += 4)
    {
        const uchar* row[4];
        ushort* out[4];
        for (int k = 0; k < 4; k++)
        {
            const size_t at = std::min(y + k, window.height - 1);
            row[k] = planes + at * step;
            out[k] = sums + at * window.width;
        }
#if CV_SIMD
        const int lanes8 = lanes<v_uint8>(), lanes16 = lanes<v_uint16>();
        for (int x = 0; x < window.width; x += lanes8)
        {
            v_uint16 lo[4], hi[4];
            for (int k = 0; k < 4; k++) lo[k] = hi[k] = vx_setzero_u16();
            for (int first = 0; first < features; first += 63)
            {
                v_uint8 s0 = vx_setzero_u8(), s1 = vx_setzero_u8(), s2 = vx_setzero_u8(), s3 = vx_setzero_u8();
                for (int i = first; i < std::min(first + 63, features); i++)
                {
                    const ptrdiff_t at = offsets[i] + x;
                    s0 = add(s0, vx_load(row[0] + at));
                    s1 = add(s1, vx_load(row[1] + at));
                    s2 = add(s2, vx_load(row[2] + at));
                    s3 = add(s3, vx_load(row[3] + at));
                }
                const v_uint8 s[4] = {s0, s1, s2, s3};
                for (int k = 0; k < 4; k++)
                {
                    v_uint16 l, h;
                    v_expand(s[k], l, h);
                    lo[k] = add(lo[k], l);
                    hi[k] = add(hi[k], h);
                }
            }
            for (int k = 0; k < 4; k++)
            {
                if (x + lanes8 <= window.width)
                {
                    v_store(out[k] + x, lo[k]);
                    v_store(out[k] + x + lanes16, hi[k]);
                    continue;
                }
                ushort end[CV_SIMD_WIDTH];
                v_store(end, lo[k]);
                v_store(end + lanes16, hi[k]);
                std::copy(end, end + (window.width - x), out[k] + x);
            }
        }
#else
        for (int k = 0; k < 4; k++)
            for (int x = 0; x < window.width; x++)
            {
                int sum = 0;
                for (int i = 0; i < features; i++) sum += row[k][x + offsets[i]];
                out[k][x] = ushort(sum);
            }
#endif
    }
}

void coarseKernel(const Mat& spread, Point tl, Size cells, uchar* planes, size_t planeStep, size_t planeSize, std::vector<uchar>& workspace)
{
    // Pixels of the image's columns, OR-ed down seven rows, two cells of empty ones before them, as many as a vector of cells needs behind.
    const int before = 8, count = cells.width + 2;   // of cells in a row, from -2 on
    const size_t length = 4 * size_t(count) + 8 * slack;
    if (workspace.size() < 2 * length) workspace.resize(2 * length);
    uchar *column = &workspace[0], *merged = column + length;
    std::fill(column, column + length, uchar(0));
    for (int cell = -2; cell < cells.height; cell++)
    {
        const int top = std::max(4 * cell, tl.y) - tl.y, bottom = std::min(4 * cell + 7, tl.y + spread.rows) - tl.y;
        uchar* inside = column + before + tl.x;
        if (top >= bottom) std::fill(inside, inside + spread.cols, uchar(0));
        else std::copy(spread.ptr(top), spread.ptr(top) + spread.cols, inside);
        for (int j = top + 1; j < bottom; j++)
        {
            const uchar* row = spread.ptr(j);
            int x = 0;
#if CV_SIMD
            for (; x <= spread.cols - lanes<v_uint8>(); x += lanes<v_uint8>()) v_store(inside + x, bor(vx_load(inside + x), vx_load(row + x)));
#endif
            for (; x < spread.cols; x++) inside[x] |= row[x];
        }
        int x = 0;
#if CV_SIMD
        for (; x < count; x += lanes<v_uint8>())
        {
            v_uint8 a, b, c, d, e, f, g, unused;
            v_load_deinterleave(column + 4 * x, a, b, c, d);
            v_load_deinterleave(column + 4 * x + 4, e, f, g, unused);
            v_store(merged + x, bor(bor(bor(a, b), bor(c, d)), bor(bor(e, f), g)));
        }
#else
        for (; x < count; x++)
        {
            const uchar* p = column + 4 * x;
            merged[x] = p[0] | p[1] | p[2] | p[3] | p[4] | p[5] | p[6];
        }
#endif
        responseKernel(merged, 0, Size(count, 1), planes + (cell + 2) * planeStep, 0, planeSize);
    }
}

int greatestKernel(const ushort* values, int n)
{
    int greatest = 0, i = 0;
#if CV_SIMD
    v_uint16 most = vx_setzero_u16();
    for (; i <= n - lanes<v_uint16>(); i += lanes<v_uint16>()) most = v_max(most, vx_load(values + i));
    greatest = v_reduce_max(most);
#endif
    for (; i < n; i++) greatest = std::max(greatest, int(values[i]));
    return greatest;
}

int atLeastKernel(const ushort* values, int n, int least, int* indices)
{
    int count = 0, i = 0;
#if CV_SIMD
    const int step = lanes<v_uint16>();
    const v_uint16 bound = vx_setall_u16(ushort(least));
    for (; i <= n - step; i += step)
    {
        const v_uint16 v = vx_load(values + i);
        if (!v_check_any(equal(v_max(v, bound), v))) continue;
        for (int j = i; j < i + step; j++)
            if (values[j] >= least) indices[count++] = j;
    }
#endif
    for (; i < n; i++)
        if (values[i] >= least) indices[count++] = i;
    return count;
}

void cellKernel(const uchar* bits, size_t step, const CellFeature* features, int n, ushort* sums)
{
#if CV_SIMD128
    const v_uint8x16 one = v_setall_u8(1);
    v_uint16x8 lo = v_setzero_u16(), hi = v_setzero_u16();
    // 3 for the orientation itself, and 1 for it or a neighbour: counted apart, a byte holds 255 features.
    for (int first = 0; first < n; first += 255)
    {
        v_uint8x16 exact = v_setzero_u8(), wide = v_setzero_u8();
        for (int i = first; i < std::min(first + 255, n); i++)
        {
            const uchar* p = bits + features[i].offset;
            unsigned rows[4];
            for (int j = 0; j < 4; j++) memcpy(rows + j, p + j * step, 4);
            const v_uint8x16 b = v_reinterpret_as_u8(v_uint32x4(rows[0], rows[1], rows[2], rows[3]));
            exact = add(exact, v_min(band(b, v_setall_u8(features[i].same)), one));
            wide = add(wide, v_min(band(b, v_setall_u8(features[i].wide)), one));
        }
        v_uint16x8 e0, e1, w0, w1;
        v_expand(exact, e0, e1);
        v_expand(wide, w0, w1);
        lo = add(add(lo, w0), add(e0, add(e0, e0)));
        hi = add(add(hi, w1), add(e1, add(e1, e1)));
    }
    v_store(sums, lo);
    v_store(sums + 8, hi);
#else
    for (int k = 0; k < 16; k++)
    {
        const uchar* at = bits + (k >> 2) * step + (k & 3);
        int sum = 0;
        for (int i = 0; i < n; i++) sum += at[features[i].offset] & features[i].same ? 4 : at[features[i].offset] & features[i].wide ? 1 : 0;
        sums[k] = ushort(sum);
    }
#endif
}

#endif   // CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

CV_CPU_OPTIMIZATION_NAMESPACE_END

}} // namespace cv::surgtrack
