// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "base/geometry.hpp"
#include "files/mesh_reader.hpp"
#include "files/mesh_io.hpp"
#include "files/text_file.hpp"
#include "model/mesh.hpp"

namespace cv { namespace surgtrack {

Mesh readMesh(const String& filename, double scale, const Matx44d& link_T_mesh)
{
    CV_CheckGT(scale, 0., "scale: metres per unit of the mesh file");
    CV_Assert(isRigid(link_T_mesh));
    Mesh mesh = readMeshFile(filename);
    mergePoints(mesh);
    if (mesh.triangles.empty())
        CV_Error(Error::StsParseError, filename + ": expected at least one triangle");
    const Matx33d R = link_T_mesh.get_minor<3, 3>(0, 0);
    const Point3d t(link_T_mesh(0, 3), link_T_mesh(1, 3), link_T_mesh(2, 3));
    for (size_t i = 0; i < mesh.vertices.size(); ++i)
        mesh.vertices[i] = R * (scale * Point3d(mesh.vertices[i])) + t;
    return mesh;
}

void writePLY(const String& filename, const Mesh& mesh)
{
    const int one = 1;
    const bool littleEndian = *(const char*)&one == 1;
    std::ostringstream file;
    file.imbue(std::locale::classic());
    file << "ply\nformat " << (littleEndian ? "binary_little_endian" : "binary_big_endian") << " 1.0\ncomment metres\n"
         << "element vertex " << mesh.vertices.size() << "\nproperty float x\nproperty float y\nproperty float z\n"
         << "element face " << mesh.triangles.size() << "\nproperty list uchar int vertex_indices\nend_header\n";
    for (size_t i = 0; i < mesh.vertices.size(); ++i)
        file.write((const char*)&mesh.vertices[i], 3 * sizeof(float));
    for (size_t i = 0; i < mesh.triangles.size(); ++i)
    {
        file.put(3);
        file.write((const char*)mesh.triangles[i].val, 3 * sizeof(int));
    }
    writeContent(filename, file.str());
}

Mesh loadMesh(const String& filename, double scale)
{
    return loadMesh(filename, scale, Matx44d::eye());
}

Mesh loadMesh(const String& filename, double scale, const Matx44d& link_T_mesh, int maxTriangles)
{
    CV_CheckGE(maxTriangles, 0, "maxTriangles: 0 keeps all");
    std::vector<Mesh> mesh(1, readMesh(filename, scale, link_T_mesh));
    if (maxTriangles)
        decimateMeshes(mesh, maxTriangles);
    computeNormals(mesh[0]);
    return mesh[0];
}

}} // namespace cv::surgtrack
