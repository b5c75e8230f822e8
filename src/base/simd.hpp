// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Arithmetic of OpenCV's universal intrinsics under one name for all versions: OpenCV 4.9 began to take away the operators of
// its vector types (NEON), 4.11 has none, 4.6 does not have the functions yet. add() and sub() of 8 and 16 bits
// saturate. For dispatched sources only.

namespace cv { namespace surgtrack {

CV_CPU_OPTIMIZATION_NAMESPACE_BEGIN

namespace {

#if CV_VERSION_MAJOR > 4 || (CV_VERSION_MAJOR == 4 && CV_VERSION_MINOR >= 9)
template <typename V> inline V add(const V& a, const V& b) { return v_add(a, b); }
template <typename V> inline V sub(const V& a, const V& b) { return v_sub(a, b); }
template <typename V> inline V mul(const V& a, const V& b) { return v_mul(a, b); }
template <typename V> inline V div(const V& a, const V& b) { return v_div(a, b); }
template <typename V> inline V band(const V& a, const V& b) { return v_and(a, b); }
template <typename V> inline V bor(const V& a, const V& b) { return v_or(a, b); }
template <typename V> inline V bxor(const V& a, const V& b) { return v_xor(a, b); }
template <typename V> inline V greater(const V& a, const V& b) { return v_gt(a, b); }
template <typename V> inline V equal(const V& a, const V& b) { return v_eq(a, b); }
template <typename V> inline int lanes() { return VTraits<V>::vlanes(); }
#else
template <typename V> inline V add(const V& a, const V& b) { return a + b; }
template <typename V> inline V sub(const V& a, const V& b) { return a - b; }
template <typename V> inline V mul(const V& a, const V& b) { return a * b; }
template <typename V> inline V div(const V& a, const V& b) { return a / b; }
template <typename V> inline V band(const V& a, const V& b) { return a & b; }
template <typename V> inline V bor(const V& a, const V& b) { return a | b; }
template <typename V> inline V bxor(const V& a, const V& b) { return a ^ b; }
template <typename V> inline V greater(const V& a, const V& b) { return a > b; }
template <typename V> inline V equal(const V& a, const V& b) { return a == b; }
template <typename V> inline int lanes() { return V::nlanes; }
#endif

} // namespace

CV_CPU_OPTIMIZATION_NAMESPACE_END

}} // namespace cv::surgtrack
