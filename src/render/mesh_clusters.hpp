// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_RENDER_MESH_CLUSTERS_HPP
#define OPENCV_SURGTRACK_SRC_RENDER_MESH_CLUSTERS_HPP

#include "opencv2/surgtrack/tool_model.hpp"

namespace cv { namespace surgtrack {

//! Neighbouring triangles that face about the same way, so that they can be left out at once.
struct MeshCluster
{
    int firstVertex, vertices;      // vertices: a multiple of ClusteredMesh::padding, the last one repeated
    int firstTriangle, triangles;   // triangles: a multiple of the same, the last ones without extent
    Point3f centre;                 // of a sphere that holds them
    float radius;
    Point3f axis;                   // of a cone that holds their normals
    float sine;                     // of its half angle; more than 1: faces all ways, or has triangles whose back is seen
    bool oneSided;                  // the triangles' backs are never seen
};

//! A mesh ordered for drawing.
struct ClusteredMesh
{
    static const int padding = 16;

    std::vector<float> x, y, z, nx, ny, nz;   // vertices and their unit normals, cluster by cluster
    std::vector<uchar> a, b, c;               // corners of the triangles, counted from the cluster's first vertex
    std::vector<MeshCluster> clusters;
    Point3f centre;                           // of a sphere that holds all
    float radius;
};

//! One normal per vertex, and triangles that refer to vertices that exist: as MeshRenderer::addMesh() has checked.
CV_EXPORTS ClusteredMesh clusterMesh(const Mesh& mesh);

}} // namespace cv::surgtrack

#endif
