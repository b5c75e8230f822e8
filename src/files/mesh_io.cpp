// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "base/geometry.hpp"
#include "files/mesh_reader.hpp"
#include "files/mesh_io.hpp"
#include "model/mesh.hpp"

#include <cctype>

#include <vtkCellArray.h>
#include <vtkCleanPolyData.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkQuadricDecimation.h>
#include <vtkSmartPointer.h>
#include <vtkTriangleFilter.h>

namespace cv { namespace surgtrack {

namespace {

vtkSmartPointer<vtkPolyData> readPolyData(const String& filename)
{
    MeshFileReader reader(filename);
    const size_t dot = filename.rfind('.');
    String extension = dot == String::npos ? String() : filename.substr(dot + 1);
    for (size_t i = 0; i < extension.size(); ++i)
        extension[i] = (char)std::tolower((uchar)extension[i]);
    if (extension == "ply")
        reader.readPLY();
    else if (extension == "stl")
        reader.readSTL();
    else if (extension == "obj")
        reader.readOBJ();
    else
        reader.fail("expected a file name ending in .ply, .stl or .obj");

    vtkNew<vtkPoints> points;
    for (size_t i = 0; i < reader.points().size(); ++i)
    {
        const Point3d& p = reader.points()[i];
        if (!(std::abs(p.x) + std::abs(p.y) + std::abs(p.z) < DBL_MAX))
            reader.fail(format("expected finite numbers, vertex %d is not", (int)i));
        points->InsertNextPoint(p.x, p.y, p.z);
    }
    vtkNew<vtkCellArray> polys;
    for (size_t at = 0; at < reader.faces().size(); at += reader.faces()[at] + 1)
    {
        polys->InsertNextCell(reader.faces()[at]);
        for (int k = 1; k <= reader.faces()[at]; ++k)
            polys->InsertCellPoint(reader.faces()[at + k]);
    }
    vtkSmartPointer<vtkPolyData> data = vtkSmartPointer<vtkPolyData>::New();
    data->SetPoints(points);
    data->SetPolys(polys);
    return data;
}

} // namespace

Mesh readMesh(const String& filename, double scale, const Matx44d& link_T_mesh)
{
    CV_CheckGT(scale, 0., "scale: metres per unit of the mesh file");
    CV_Assert(isRigid(link_T_mesh));
    vtkNew<vtkTriangleFilter> triangles;
    triangles->SetInputData(readPolyData(filename));
    triangles->PassVertsOff();
    triangles->PassLinesOff();
    vtkNew<vtkCleanPolyData> clean;
    clean->SetInputConnection(triangles->GetOutputPort());
    clean->SetTolerance(0);
    clean->Update();

    Mesh mesh;
    fromPolyData(clean->GetOutput(), mesh);
    mesh.normals.clear();
    if (mesh.triangles.empty())
        CV_Error(Error::StsParseError, filename + ": expected at least one triangle");
    const Matx33d R = link_T_mesh.get_minor<3, 3>(0, 0);
    const Point3d t(link_T_mesh(0, 3), link_T_mesh(1, 3), link_T_mesh(2, 3));
    for (size_t i = 0; i < mesh.vertices.size(); ++i)
        mesh.vertices[i] = R * (scale * Point3d(mesh.vertices[i])) + t;
    return mesh;
}

void decimateMeshes(std::vector<Mesh>& meshes, int maxTriangles)
{
    // All meshes go into one data set, side by side along x in slots too wide to stray from. So one queue of errors decides
    // what goes, and the triangles stay where they are needed most; measured on a tool of 80,000 triangles, the worst mesh
    // comes out several times closer than with a number of triangles for each.
    double slot = 0, triangles = 0;
    std::vector<double> centres;
    for (size_t m = 0; m < meshes.size(); ++m)
    {
        double low = DBL_MAX, high = -DBL_MAX;
        for (size_t i = 0; i < meshes[m].vertices.size(); ++i)
        {
            low = std::min(low, (double)meshes[m].vertices[i].x);
            high = std::max(high, (double)meshes[m].vertices[i].x);
        }
        centres.push_back((low + high) / 2);
        slot = std::max(slot, 2 * (high - low));
        triangles += (double)meshes[m].triangles.size();
    }
    if (triangles <= maxTriangles)
        return;
    vtkNew<vtkPoints> points;
    points->SetDataTypeToDouble();
    vtkNew<vtkCellArray> polys;
    for (size_t m = 0; m < meshes.size(); ++m)
    {
        const vtkIdType first = points->GetNumberOfPoints();
        for (size_t i = 0; i < meshes[m].vertices.size(); ++i)
        {
            const Point3d p = meshes[m].vertices[i];
            points->InsertNextPoint(p.x - centres[m] + (double)m * slot, p.y, p.z);
        }
        for (size_t i = 0; i < meshes[m].triangles.size(); ++i)
        {
            const Vec3i& t = meshes[m].triangles[i];
            const vtkIdType ids[] = { first + t[0], first + t[1], first + t[2] };
            polys->InsertNextCell(3, ids);
        }
    }
    vtkNew<vtkPolyData> all;
    all->SetPoints(points);
    all->SetPolys(polys);
    vtkNew<vtkQuadricDecimation> decimation;
    decimation->SetInputData(all);
    decimation->SetTargetReduction(1 - maxTriangles / triangles);
    decimation->VolumePreservationOn();
    decimation->Update();

    vtkPolyData* result = decimation->GetOutput();
    std::vector<std::vector<int> > newIndex(meshes.size());
    for (size_t m = 0; m < meshes.size(); ++m)
    {
        meshes[m] = Mesh();
        newIndex[m].assign((size_t)result->GetNumberOfPoints(), -1);
    }
    vtkIdType n;
    const vtkIdType* ids;
    for (result->GetPolys()->InitTraversal(); result->GetPolys()->GetNextCell(n, ids); )
    {
        double p[3];
        result->GetPoint(ids[0], p);
        const int m = std::min(std::max(cvRound(p[0] / slot), 0), (int)meshes.size() - 1);
        Vec3i triangle;
        for (int k = 0; k < 3; ++k)
        {
            int& index = newIndex[m][(size_t)ids[k]];
            if (index < 0)
            {
                result->GetPoint(ids[k], p);
                index = (int)meshes[m].vertices.size();
                meshes[m].vertices.push_back(Point3f((float)(p[0] + centres[m] - m * slot), (float)p[1], (float)p[2]));
            }
            triangle[k] = index;
        }
        meshes[m].triangles.push_back(triangle);
    }
}

void writePLY(const String& filename, const Mesh& mesh)
{
    const int one = 1;
    const bool littleEndian = *(const char*)&one == 1;
    std::ofstream file(filename.c_str(), std::ios::binary);
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
    file.close();
    if (!file)
        CV_Error(Error::StsError, filename + ": cannot be written");
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
