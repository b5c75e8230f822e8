// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "model/mesh.hpp"

#include <vtkCellArray.h>
#include <vtkCleanPolyData.h>
#include <vtkDataArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataNormals.h>
#include <vtkSmartPointer.h>

namespace cv { namespace surgtrack {

Mesh::Mesh() {}

Mesh::Mesh(const std::vector<Point3f>& _vertices, const std::vector<Point3f>& _normals, const std::vector<Vec3i>& _triangles)
    : vertices(_vertices), normals(_normals), triangles(_triangles)
{
}

namespace {

const double FEATURE_ANGLE = 35;   // [degree]; sharper edges are creases

vtkSmartPointer<vtkPolyData> toPolyData(const Mesh& mesh)
{
    vtkNew<vtkPoints> points;
    points->SetNumberOfPoints((vtkIdType)mesh.vertices.size());
    for (size_t i = 0; i < mesh.vertices.size(); ++i)
        points->SetPoint((vtkIdType)i, mesh.vertices[i].x, mesh.vertices[i].y, mesh.vertices[i].z);
    vtkNew<vtkCellArray> polys;
    for (size_t i = 0; i < mesh.triangles.size(); ++i)
    {
        const vtkIdType ids[] = { mesh.triangles[i][0], mesh.triangles[i][1], mesh.triangles[i][2] };
        polys->InsertNextCell(3, ids);
    }
    vtkSmartPointer<vtkPolyData> data = vtkSmartPointer<vtkPolyData>::New();
    data->SetPoints(points);
    data->SetPolys(polys);
    return data;
}

bool isClosed(vtkPolyData* data)
{
    std::vector<std::pair<vtkIdType, vtkIdType> > edges;
    vtkIdType n;
    const vtkIdType* ids;
    vtkCellArray* polys = data->GetPolys();
    for (polys->InitTraversal(); polys->GetNextCell(n, ids); )
        for (vtkIdType k = 0; k < n; ++k)
            edges.push_back(std::minmax(ids[k], ids[(k + 1) % n]));
    std::sort(edges.begin(), edges.end());
    for (size_t i = 0; i < edges.size(); i += 2)
        if (i + 1 == edges.size() || edges[i] != edges[i + 1])
            return false;
    return !edges.empty();
}

} // namespace

void fromPolyData(vtkPolyData* data, Mesh& mesh)
{
    mesh = Mesh();
    for (vtkIdType i = 0; i < data->GetNumberOfPoints(); ++i)
    {
        double p[3];
        data->GetPoint(i, p);
        mesh.vertices.push_back(Point3f((float)p[0], (float)p[1], (float)p[2]));
    }
    vtkIdType n;
    const vtkIdType* ids;
    vtkCellArray* polys = data->GetPolys();
    for (polys->InitTraversal(); polys->GetNextCell(n, ids); )
        if (n == 3 && ids[0] != ids[1] && ids[1] != ids[2] && ids[2] != ids[0])
            mesh.triangles.push_back(Vec3i((int)ids[0], (int)ids[1], (int)ids[2]));
    vtkDataArray* normals = data->GetPointData()->GetNormals();
    for (vtkIdType i = 0; normals && i < normals->GetNumberOfTuples(); ++i)
    {
        double p[3];
        normals->GetTuple(i, p);
        mesh.normals.push_back(Point3f((float)p[0], (float)p[1], (float)p[2]));
    }
}

void computeNormals(Mesh& mesh)
{
    vtkNew<vtkCleanPolyData> clean;
    clean->SetInputData(toPolyData(mesh));
    clean->SetTolerance(0);
    clean->Update();
    vtkNew<vtkPolyDataNormals> normals;
    normals->SetInputData(clean->GetOutput());
    normals->SetFeatureAngle(FEATURE_ANGLE);
    normals->SplittingOn();
    normals->ConsistencyOn();
    normals->SetAutoOrientNormals(isClosed(clean->GetOutput()));
    normals->Update();
    fromPolyData(normals->GetOutput(), mesh);
}

}} // namespace cv::surgtrack
