#ifndef OPENCV_SURGTRACK_PRECOMP_HPP
#define OPENCV_SURGTRACK_PRECOMP_HPP
#include "opencv2/surgtrack.hpp"
#include "opencv2/core/private.hpp"
#endif
