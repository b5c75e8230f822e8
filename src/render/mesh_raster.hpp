// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_RENDER_MESH_RASTER_HPP
#define OPENCV_SURGTRACK_SRC_RENDER_MESH_RASTER_HPP

#include "opencv2/surgtrack/camera.hpp"
#include "render/mesh_clusters.hpp"

// Exported for the tests alone.

namespace cv { namespace surgtrack {

//! A camera's window, in float, for drawing. Image coordinates are in 1/256 pixel from the window's first pixel.
struct RasterView
{
    float fx, fy, cx, cy;            // [1/256 pixel]
    float k[12];                     // of the lens, see CameraModel::k
    bool distorted;
    int width, height;               // [pixel]
    // Field of view [x / z, y / z]: of the window; and of what is drawn without being clipped, a little larger.
    float left, right, top, bottom, guardLeft, guardRight, guardTop, guardBottom;
};

CV_EXPORTS RasterView rasterView(const CameraModel& camera, const Rect& window);

//! A mesh to be drawn.
struct RasterInstance
{
    const ClusteredMesh* mesh;
    Matx44f camera_T_mesh;
    int id;
};

//! What is drawn into, and workspace that is kept from drawing to drawing.
struct CV_EXPORTS RasterTarget
{
    //! Empties it. Everything is to be drawn.
    void create(Size size);
    //! Nothing is to be drawn but what include() names.
    void exclude();
    void include(const Rect& pixels);

    // A row is `step` elements, of which those after the window's width may be overrun.
    float* w;              // 1 / z of the nearest surface, 0 where there is none
    int* surface;          // 256 * id + shading of it
    size_t step;

    static const int tile = 8;      // [pixel]
    float* farthest;       // least w in each tile of tile x tile pixels, or less; FLT_MAX where nothing is to be drawn
    uchar* changed;        // 1 for tiles drawn into since
    size_t tileStep;

    struct Item
    {
        float z;           // of its nearest point, or less
        int instance, cluster;
        bool operator<(const Item& b) const { return z != b.z ? z < b.z : instance != b.instance ? instance < b.instance : cluster < b.cluster; }
    };
    std::vector<Item> order;

private:
    std::vector<float> w_, farthest_;
    std::vector<int> surface_;
    std::vector<uchar> changed_;
};

//! Draws meshes.
CV_EXPORTS void rasterize(const RasterView& view, const std::vector<RasterInstance>& instances, RasterTarget& target);

//! The same without vector instructions; the result is the same bit for bit.
namespace plain {
CV_EXPORTS void rasterize(const RasterView& view, const std::vector<RasterInstance>& instances, RasterTarget& target);
} // namespace plain

//! A row of the target, as the maps of a Rendering.
void unpackRow(const float* w, const int* surface, int width, float* depth, uchar* ids, uchar* shading);

}} // namespace cv::surgtrack

#endif
