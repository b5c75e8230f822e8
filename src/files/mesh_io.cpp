// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "base/geometry.hpp"
#include "files/mesh_check.hpp"
#include "files/mesh_io.hpp"
#include "model/mesh.hpp"

#include <cctype>

#include <vtkCallbackCommand.h>
#include <vtkCellArray.h>
#include <vtkCleanPolyData.h>
#include <vtkExecutive.h>
#include <vtkNew.h>
#include <vtkOBJReader.h>
#include <vtkPLYReader.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkQuadricDecimation.h>
#include <vtkSTLReader.h>
#include <vtkSmartPointer.h>
#include <vtkTriangleFilter.h>

namespace cv { namespace surgtrack {

namespace {

// With an observer VTK hands over its errors instead of printing them.
void collectError(vtkObject*, unsigned long, void* errors, void* message)
{
    if (((String*)errors)->empty() && message)
        *(String*)errors = (const char*)message;
}

vtkSmartPointer<vtkPolyData> runReader(vtkAbstractPolyDataReader* reader, const String& filename, const MeshFileChecker& checker)
{
    String errors;
    vtkNew<vtkCallbackCommand> observer;
    observer->SetCallback(collectError);
    observer->SetClientData(&errors);
    const unsigned long events[] = { vtkCommand::ErrorEvent, vtkCommand::WarningEvent };
    for (int i = 0; i < 2; ++i)
    {
        reader->AddObserver(events[i], observer);
        reader->GetExecutive()->AddObserver(events[i], observer);
    }
    reader->SetFileName(filename.c_str());
    reader->Update();
    if (!errors.empty() || reader->GetErrorCode())
        checker.fail("not readable: " + errors.substr(0, errors.find_last_not_of(" \n") + 1));
    return reader->GetOutput();
}

vtkSmartPointer<vtkPolyData> readPolyData(const String& filename)
{
    MeshFileChecker checker(filename);
    const size_t dot = filename.rfind('.');
    String extension = dot == String::npos ? String() : filename.substr(dot + 1);
    for (size_t i = 0; i < extension.size(); ++i)
        extension[i] = (char)std::tolower((uchar)extension[i]);

    vtkSmartPointer<vtkPolyData> data;
    if (extension == "ply")
    {
        checker.checkPLY();
        vtkNew<vtkPLYReader> reader;
        reader->ReadFromInputStringOn();
        reader->SetInputString(checker.content() + "\n");   // a text that ends without a line feed crashes it
        data = runReader(reader, filename, checker);
    }
    else if (extension == "stl")
    {
        checker.checkSTL();
        vtkNew<vtkSTLReader> reader;
        reader->MergingOff();
        data = runReader(reader, filename, checker);
    }
    else if (extension == "obj")
    {
        checker.checkOBJ();
        data = runReader(vtkNew<vtkOBJReader>(), filename, checker);
    }
    else
        checker.fail("expected a file name ending in .ply, .stl or .obj");
    checker.checkCounts(data->GetNumberOfPoints(), data->GetNumberOfPolys());

    for (vtkIdType i = 0; i < data->GetNumberOfPoints(); ++i)
    {
        double p[3];
        data->GetPoint(i, p);
        if (!(std::abs(p[0]) + std::abs(p[1]) + std::abs(p[2]) < DBL_MAX))
            checker.fail(format("expected finite numbers, vertex %lld is not", (long long)i));
    }
    vtkIdType n;
    const vtkIdType* ids;
    vtkCellArray* polys = data->GetPolys();
    for (polys->InitTraversal(); polys->GetNextCell(n, ids); )
        for (vtkIdType k = 0; k < n; ++k)
            if (ids[k] < 0 || ids[k] >= data->GetNumberOfPoints())
                checker.fail(format("a face names vertex %lld of %lld", (long long)ids[k], (long long)data->GetNumberOfPoints()));
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
