// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "base/memory.hpp"
#include "render/mesh_raster.simd.hpp"
#include "render/mesh_raster.simd_declarations.hpp"

namespace cv { namespace surgtrack {

// Drawn without clipping: this far around the window, but hardly beyond the image, where a lens model may fold back.
const double windowGuard = 64;      // [pixel]
const double imageGuard = 0.02;     // of the image's field of view

RasterView rasterView(const CameraModel& camera, const Rect& window)
{
    RasterView v;
    v.fx = float(256 * camera.fx);
    v.fy = float(256 * camera.fy);
    v.cx = float(256 * (camera.cx - window.x));
    v.cy = float(256 * (camera.cy - window.y));
    for (int i = 0; i < 12; i++) v.k[i] = float(camera.k[i]);
    v.distorted = camera.hasDistortion();
    v.width = window.width;
    v.height = window.height;
    const Rect2d seen = camera.fieldOfView(window), all = camera.fieldOfView(Rect(Point(), camera.imageSize()));
    v.left = float(seen.x);
    v.right = float(seen.x + seen.width);
    v.top = float(seen.y);
    v.bottom = float(seen.y + seen.height);
    const double gx = windowGuard / camera.fx, gy = windowGuard / camera.fy, hx = imageGuard * all.width, hy = imageGuard * all.height;
    v.guardLeft = float(std::max(seen.x - gx, all.x - hx));
    v.guardRight = float(std::min(seen.x + seen.width + gx, all.x + all.width + hx));
    v.guardTop = float(std::max(seen.y - gy, all.y - hy));
    v.guardBottom = float(std::min(seen.y + seen.height + gy, all.y + all.height + hy));
    return v;
}

void RasterTarget::create(Size size)
{
    const size_t overrun = 32, line = 16;   // elements
    step = alignSize(size.width + overrun, int(line));
    tileStep = (size.width + tile - 1) / tile;
    const size_t pixels = step * size.height + line, tiles = tileStep * ((size.height + tile - 1) / tile);
    w_.reserve(roomFor(pixels, w_.capacity()));
    surface_.reserve(roomFor(pixels, surface_.capacity()));
    farthest_.reserve(roomFor(tiles, farthest_.capacity()));
    w_.assign(pixels, 0.f);
    surface_.assign(pixels, 0);
    farthest_.assign(tiles, 0.f);
    changed_.reserve(roomFor(tiles, changed_.capacity()));
    changed_.assign(tiles, uchar(0));
    changed = &changed_[0];
    w = alignPtr(&w_[0], int(line * sizeof(float)));
    surface = alignPtr(&surface_[0], int(line * sizeof(int)));
    farthest = &farthest_[0];
}

void RasterTarget::exclude()
{
    std::fill(farthest_.begin(), farthest_.end(), FLT_MAX);
}

void RasterTarget::include(const Rect& pixels)
{
    if (pixels.empty()) return;
    const int x0 = pixels.x / tile, x1 = (pixels.x + pixels.width - 1) / tile;
    for (int y = pixels.y / tile; y <= (pixels.y + pixels.height - 1) / tile; y++)
        std::fill(farthest + y * tileStep + x0, farthest + y * tileStep + x1 + 1, 0.f);
}

void rasterize(const RasterView& view, const std::vector<RasterInstance>& instances, RasterTarget& target)
{
    CV_CPU_DISPATCH(rasterizeKernel, (view, instances, target), CV_CPU_DISPATCH_MODES_ALL);
}

namespace plain {

void rasterize(const RasterView& view, const std::vector<RasterInstance>& instances, RasterTarget& target)
{
    cpu_baseline::rasterizePlainKernel(view, instances, target);
}

} // namespace plain

void unpackRow(const float* w, const int* surface, int width, float* depth, uchar* ids, uchar* shading)
{
    CV_CPU_DISPATCH(unpackRowKernel, (w, surface, width, depth, ids, shading), CV_CPU_DISPATCH_MODES_ALL);
}

}} // namespace cv::surgtrack
