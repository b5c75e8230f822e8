// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_LAB_SYNTHETIC_SYNTHETIC_IMAGE_HPP
#define OPENCV_SURGTRACK_SRC_LAB_SYNTHETIC_SYNTHETIC_IMAGE_HPP

#include "opencv2/surgtrack/mesh_renderer.hpp"

namespace cv { namespace surgtrack {

//! What a link looks like.
struct ToolMaterial
{
    Vec3f colour;         //!< BGR, share of the light that is scattered
    float specular;       //!< share of the light that is mirrored
    int shininess;        //!< exponent of the highlight, a power of two
};

//! What links look like. @param wristDepth of each link how many joints of the wrist it hangs on: 0 = the shaft
std::vector<ToolMaterial> toolMaterials(const std::vector<int>& wristDepth);

//! Tissue: mottled, with veins and wet spots. CV_8UC3, BGR.
Mat makeTissue(Size size, RNG& rng);

//! How much of the endoscope's light reaches a pixel, 0..1. CV_32FC1.
Mat makeVignette(Size size);

/** Shades the tools and lays them over the background.

Light comes from beside the lens and from one side, with highlights of both, on normals taken from the depth map: on purpose
not the shading that templates are drawn with.

@param doubled drawing of the tools at twice the size of the image
@param doubledCamera its camera
@param materials by Rendering::ids - 1
@param sideLight unit vector to the second light
@param background CV_8UC3
@param vignette CV_32FC1
@param light CV_32FC3, result: squares of grey levels, which are close to what light a camera takes in */
void composeImage(const Rendering& doubled, const CameraModel& doubledCamera, const std::vector<ToolMaterial>& materials,
                  const Vec3f& sideLight, const Mat& background, const Mat& vignette, Mat& light);

}} // namespace cv::surgtrack

#endif
