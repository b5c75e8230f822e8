// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// The kernels of quantised gradient orientations with OpenCV's universal intrinsics, row by row: a row of every stage stays in
// the first-level cache until the next stage has used it. namespace plain in qgo.cpp is the definition.

#include "opencv2/core/hal/intrin.hpp"
#include "qgo.hpp"

namespace cv { namespace surgtrack {

CV_CPU_OPTIMIZATION_NAMESPACE_BEGIN

void quantizeKernel(const Mat& image, const Rect& window, int squaredThreshold, Mat& orientations, std::vector<uchar>& workspace);
void spreadKernel(const Mat& src, Mat& dst, int size, std::vector<uchar>& workspace);
void responseKernel(const uchar* bits, size_t bitsStep, Size size, uchar* planes, size_t planeStep, size_t planeSize);
void similarityKernel(const uchar* planes, size_t step, const int* offsets, int features, Size window, ushort* sums);

#ifndef CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

namespace {

#if CV_SIMD

// OpenCV 4.11 took away the operators of its vector types, 4.6 does not have the functions yet.
#if CV_VERSION_MAJOR > 4 || (CV_VERSION_MAJOR == 4 && CV_VERSION_MINOR >= 11)
template <typename V> inline V add(const V& a, const V& b) { return v_add(a, b); }
template <typename V> inline V sub(const V& a, const V& b) { return v_sub(a, b); }
template <typename V> inline V band(const V& a, const V& b) { return v_and(a, b); }
template <typename V> inline V bor(const V& a, const V& b) { return v_or(a, b); }
template <typename V> inline V bxor(const V& a, const V& b) { return v_xor(a, b); }
template <typename V> inline V greater(const V& a, const V& b) { return v_gt(a, b); }
template <typename V> inline V equal(const V& a, const V& b) { return v_eq(a, b); }
template <typename V> inline int lanes() { return VTraits<V>::vlanes(); }
#else
template <typename V> inline V add(const V& a, const V& b) { return a + b; }
template <typename V> inline V sub(const V& a, const V& b) { return a - b; }
template <typename V> inline V band(const V& a, const V& b) { return a & b; }
template <typename V> inline V bor(const V& a, const V& b) { return a | b; }
template <typename V> inline V bxor(const V& a, const V& b) { return a ^ b; }
template <typename V> inline V greater(const V& a, const V& b) { return a > b; }
template <typename V> inline V equal(const V& a, const V& b) { return a == b; }
template <typename V> inline int lanes() { return V::nlanes; }
#endif
// 16-bit sums here never reach the saturation of the plain operators; 8-bit sums have a bound of their own below.

const int slack = 128;   // bytes that a row may be overrun by

inline v_uint16 weighted(const v_uint16& a06, const v_uint16& a15, const v_uint16& a24, const v_uint16& a3)
{
    return add(add(v_shl<1>(a06), v_mul_wrap(a15, vx_setall_u16(7))), add(v_mul_wrap(a24, vx_setall_u16(14)), v_mul_wrap(a3, vx_setall_u16(18))));
}

// The seven rows above and below, weighted, to 10 bits.
void blurVertically(const uchar* const* rows, int n, ushort* dst)
{
    const int step = lanes<v_uint16>();
    int i = 0;
    for (; i <= n - step; i += step)
    {
        const v_uint16 a06 = add(vx_load_expand(rows[0] + i), vx_load_expand(rows[6] + i));
        const v_uint16 a15 = add(vx_load_expand(rows[1] + i), vx_load_expand(rows[5] + i));
        const v_uint16 a24 = add(vx_load_expand(rows[2] + i), vx_load_expand(rows[4] + i));
        v_store(dst + i, v_shr<4>(add(weighted(a06, a15, a24, vx_load_expand(rows[3] + i)), vx_setall_u16(8))));
    }
    for (; i < n; i++)
        dst[i] = ushort((2 * (rows[0][i] + rows[6][i]) + 7 * (rows[1][i] + rows[5][i]) + 14 * (rows[2][i] + rows[4][i]) + 18 * rows[3][i] + 8) >> 4);
}

// src holds three pixels more on either side; may overrun.
void blurHorizontally(const ushort* src, int channels, int n, ushort* dst)
{
    const int c = channels;
    for (int i = 0; i < n; i += lanes<v_uint16>())
    {
        const ushort* p = src + i;
        const v_uint16 a06 = add(vx_load(p), vx_load(p + 6 * c)), a15 = add(vx_load(p + c), vx_load(p + 5 * c));
        const v_uint16 a24 = add(vx_load(p + 2 * c), vx_load(p + 4 * c));
        v_store(dst + i, v_shr<6>(add(weighted(a06, a15, a24, vx_load(p + 3 * c)), vx_setall_u16(32))));
    }
}

// Sobel at the middle one of three blurred rows, which hold one pixel more on either side; may overrun.
void sobel(const short* above, const short* row, const short* below, int channels, int n, short* gx, short* gy)
{
    const int c = channels;
    for (int i = 0; i < n; i += lanes<v_int16>())
    {
        const v_int16 a0 = vx_load(above + i), a1 = vx_load(above + i + c), a2 = vx_load(above + i + 2 * c);
        const v_int16 b0 = vx_load(below + i), b1 = vx_load(below + i + c), b2 = vx_load(below + i + 2 * c);
        const v_int16 horizontal = sub(vx_load(row + i + 2 * c), vx_load(row + i));
        const v_int16 right = add(a2, b2), left = add(a0, b0);
        v_store(gx + i, add(add(horizontal, horizontal), sub(right, left)));
        const v_int16 middle = sub(b1, a1);
        v_store(gy + i, add(add(middle, middle), sub(add(b0, b2), add(a0, a2))));
    }
}

inline void strongest(v_int16& gx, v_int16& gy, v_uint16& best, const v_int16& x, const v_int16& y)
{
    const v_uint16 size = add(v_abs(x), v_abs(y));
    const v_int16 better = v_reinterpret_as_s16(greater(size, best));
    gx = v_select(better, x, gx);
    gy = v_select(better, y, gy);
    best = v_max(best, size);
}

// One bit for the direction of (gx, gy) modulo 180 degrees; see plain::orientationBin().
inline v_uint16 orientationBit(const v_int16& gx, const v_int16& gy)
{
    const v_uint16 ax = v_shl<3>(v_abs(gx)), ay = v_shl<3>(v_abs(gy));
    const v_uint16 tan1 = vx_setall_u16(13036), tan2 = vx_setall_u16(43790);
    const v_uint16 m1 = greater(ay, v_mul_hi(ax, tan1)), m2 = greater(ay, v_mul_hi(ax, tan2));
    const v_uint16 m3 = greater(v_mul_hi(ay, tan2), ax), m4 = greater(v_mul_hi(ay, tan1), ax);
    const v_uint16 one = vx_setall_u16(1), two = vx_setall_u16(2), four = vx_setall_u16(4), eight = vx_setall_u16(8);
    // Each mask implies those before it: 1, 2, 4, 8, 16 if the signs agree, else 1, 128, 64, 32, 16.
    const v_uint16 up = add(add(add(one, band(m1, one)), add(band(m2, two), band(m3, four))), band(m4, eight));
    const v_uint16 down = sub(add(one, band(m1, vx_setall_u16(127))),
                              add(band(m2, vx_setall_u16(64)), add(band(m3, vx_setall_u16(32)), band(m4, vx_setall_u16(16)))));
    const v_uint16 opposite = v_reinterpret_as_u16(greater(vx_setzero_s16(), bxor(gx, gy)));
    return v_select(opposite, down, up);
}

inline v_uint16 isStrong(const v_int16& gx, const v_int16& gy, const v_int32& belowThreshold)
{
    v_int16 lo, hi;
    v_zip(gx, gy, lo, hi);
    return v_reinterpret_as_u16(v_pack(greater(v_dotprod(lo, lo), belowThreshold), greater(v_dotprod(hi, hi), belowThreshold)));
}

// Bits and strength of a row from its gradients; may overrun.
void orient(const short* gx, const short* gy, int channels, int n, int squaredThreshold, uchar* bits, uchar* strong)
{
    const v_int32 belowThreshold = vx_setall_s32(squaredThreshold - 1);
    const int step = lanes<v_int16>();
    for (int i = 0; i < n; i += 2 * step)
    {
        v_uint16 bit[2], mask[2];
        for (int j = 0; j < 2; j++)
        {
            const int at = i + j * step;
            v_int16 x, y;
            if (channels == 1)
            {
                x = vx_load(gx + at);
                y = vx_load(gy + at);
            }
            else
            {
                v_int16 x1, x2, y1, y2;
                v_load_deinterleave(gx + 3 * at, x, x1, x2);
                v_load_deinterleave(gy + 3 * at, y, y1, y2);
                v_uint16 best = add(v_abs(x), v_abs(y));
                strongest(x, y, best, x1, y1);
                strongest(x, y, best, x2, y2);
            }
            bit[j] = orientationBit(x, y);
            mask[j] = isStrong(x, y, belowThreshold);
        }
        v_store(bits + i, v_pack(bit[0], bit[1]));
        v_store(strong + i, v_reinterpret_as_u8(v_pack(v_reinterpret_as_s16(mask[0]), v_reinterpret_as_s16(mask[1]))));
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
    memory += (count * sizeof(T) + 3 * slack) & ~size_t(slack - 1);
    return p;
}

#endif   // CV_SIMD

} // namespace

void quantizeKernel(const Mat& image, const Rect& window, int squaredThreshold, Mat& orientations, std::vector<uchar>& workspace)
{
#if CV_SIMD
    const int c = image.channels(), w = window.width, h = window.height;
    const int x0 = window.x - 5, n = w + 10;                                     // columns needed, some beyond the image
    const int inside0 = std::max(x0, 0), inside1 = std::min(x0 + n, image.cols);
    const int blurredN = (w + 4) * c, gradientN = (w + 2) * c;

    const size_t bytes = sizeof(short) * size_t(c) * (n + 3 * (w + 4) + 2 * (w + 2)) + 8 * size_t(w + 2) + 20 * 3 * slack;
    if (workspace.size() < bytes) workspace.resize(bytes);
    uchar* memory = alignPtr(&workspace[0], slack);
    ushort* column = take<ushort>(memory, size_t(n) * c);
    short *blurred[3], *gx, *gy;
    uchar *bits[3], *strong[2];
    for (int i = 0; i < 3; i++) blurred[i] = take<short>(memory, blurredN);
    gx = take<short>(memory, gradientN);
    gy = take<short>(memory, gradientN);
    for (int i = 0; i < 3; i++) bits[i] = take<uchar>(memory, w + 2);
    for (int i = 0; i < 2; i++) strong[i] = take<uchar>(memory, w + 2);
    uchar *ones = take<uchar>(memory, w + 2), *twos = take<uchar>(memory, w + 2), *voted = take<uchar>(memory, w);

    // Row y of the window needs bits of y - 1 .. y + 1, blurred rows of y - 2 .. y + 2, image rows of y - 5 .. y + 5.
    for (int y = -2; y < h + 2; y++)
    {
        const uchar* rows[7];
        for (int j = 0; j < 7; j++) rows[j] = image.ptr(std::min(std::max(window.y + y + j - 3, 0), image.rows - 1)) + inside0 * c;
        ushort* inside = column + (inside0 - x0) * c;
        blurVertically(rows, (inside1 - inside0) * c, inside);
        for (int i = (inside0 - x0) * c - 1; i >= 0; i--) column[i] = column[i + c];
        for (int i = (inside1 - x0) * c; i < n * c; i++) column[i] = column[i - c];
        blurHorizontally(column, c, blurredN, reinterpret_cast<ushort*>(blurred[(y + 3) % 3]));
        if (y < 0) continue;
        // blurred rows y - 2, y - 1, y are there: bits of row y - 1
        sobel(blurred[(y + 1) % 3], blurred[(y + 2) % 3], blurred[(y + 3) % 3], c, gradientN, gx, gy);
        orient(gx, gy, c, w + 2, squaredThreshold, bits[(y + 2) % 3], strong[(y + 2) % 2]);
        if (y < 2) continue;
        // bits of rows y - 3, y - 2, y - 1: row y - 2 of the result
        vote(bits[y % 3], bits[(y + 1) % 3], bits[(y + 2) % 3], strong[(y + 1) % 2], w, ones, twos, voted);
        std::copy(voted, voted + w, orientations.ptr(y - 2));
    }
#else
    CV_UNUSED(workspace);
    plain::quantize(image, window, squaredThreshold, orientations);
#endif
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
        const v_uint8 zero = vx_setzero_u8(), one = vx_setall_u8(1), four = vx_setall_u8(4);
        for (; x <= size.width - step; x += step)
        {
            const v_uint8 b = vx_load(src + x);
            for (int bin = 0; bin < 8; bin++)
            {
                const v_uint8 noSame = equal(band(b, vx_setall_u8(uchar(1 << bin))), zero);
                const v_uint8 noNext = equal(band(b, vx_setall_u8(uchar(1 << ((bin + 1) & 7) | 1 << ((bin + 7) & 7)))), zero);
                v_store(dst + bin * planeSize + x, v_select(noSame, v_select(noNext, zero, one), four));
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
   planes[offsets[i] + y * step + x]. Responses are at most 4, so 63 of them fit into 8 bits: 63 * 4 = 252. Reads up to a
   vector beyond the end of each row. */
void similarityKernel(const uchar* planes, size_t step, const int* offsets, int features, Size window, ushort* sums)
{
    for (int y = 0; y < window.height; y++)
    {
        const uchar* row = planes + y * step;
        ushort* out = sums + size_t(y) * window.width;
#if CV_SIMD
        const int lanes8 = lanes<v_uint8>(), lanes16 = lanes<v_uint16>();
        for (int x = 0; x < window.width; x += lanes8)
        {
            v_uint16 lo = vx_setzero_u16(), hi = vx_setzero_u16();
            for (int first = 0; first < features; first += 63)
            {
                const int last = std::min(first + 63, features);
                v_uint8 even = vx_setzero_u8(), odd = vx_setzero_u8();
                int i = first;
                for (; i < last - 1; i += 2)
                {
                    even = add(even, vx_load(row + x + offsets[i]));
                    odd = add(odd, vx_load(row + x + offsets[i + 1]));
                }
                if (i < last) even = add(even, vx_load(row + x + offsets[i]));
                v_uint16 l, h;
                v_expand(add(even, odd), l, h);
                lo = add(lo, l);
                hi = add(hi, h);
            }
            if (x + lanes8 <= window.width)
            {
                v_store(out + x, lo);
                v_store(out + x + lanes16, hi);
            }
            else
            {
                ushort end[CV_SIMD_WIDTH];
                v_store(end, lo);
                v_store(end + lanes16, hi);
                std::copy(end, end + window.width - x, out + x);
            }
        }
#else
        for (int x = 0; x < window.width; x++)
        {
            int sum = 0;
            for (int i = 0; i < features; i++) sum += row[x + offsets[i]];
            out[x] = ushort(sum);
        }
#endif
    }
}

#endif   // CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

CV_CPU_OPTIMIZATION_NAMESPACE_END

}} // namespace cv::surgtrack
