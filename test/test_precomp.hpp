#ifndef OPENCV_SURGTRACK_TEST_PRECOMP_HPP
#define OPENCV_SURGTRACK_TEST_PRECOMP_HPP
#include "opencv2/ts.hpp"
#include "opencv2/surgtrack.hpp"
#include "opencv2/surgtrack/lab.hpp"
#endif
