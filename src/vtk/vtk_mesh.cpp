// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "vtk/vtk_mesh.hpp"

#include <vtkCellArray.h>
#include <vtkFloatArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>

namespace cv { namespace surgtrack {

vtkSmartPointer<vtkPolyData> toPolyData(const Mesh& mesh)
{
    CV_CheckEQ(mesh.normals.size(), mesh.vertices.size(), "a mesh needs one normal per vertex");
    if (mesh.triangles.empty()) CV_Error(Error::StsBadArg, "mesh has no triangles");
    if (!checkRange(mesh.vertices) || !checkRange(mesh.normals)) CV_Error(Error::StsBadArg, "mesh has a vertex or normal that is not finite");

    vtkNew<vtkPoints> points;
    points->SetDataTypeToFloat();
    points->SetNumberOfPoints(vtkIdType(mesh.vertices.size()));
    vtkNew<vtkFloatArray> normals;
    normals->SetNumberOfComponents(3);
    normals->SetNumberOfTuples(vtkIdType(mesh.vertices.size()));
    for (size_t i = 0; i < mesh.vertices.size(); i++)
    {
        const Point3f& p = mesh.vertices[i];
        points->SetPoint(vtkIdType(i), p.x, p.y, p.z);
        normals->SetTuple3(vtkIdType(i), mesh.normals[i].x, mesh.normals[i].y, mesh.normals[i].z);
    }
    vtkNew<vtkCellArray> triangles;
    for (size_t i = 0; i < mesh.triangles.size(); i++)
    {
        vtkIdType ids[3];
        for (int j = 0; j < 3; j++)
        {
            ids[j] = mesh.triangles[i][j];
            CV_CheckGE(int(ids[j]), 0, "triangle refers to a vertex that does not exist");
            CV_CheckLT((size_t)ids[j], mesh.vertices.size(), "triangle refers to a vertex that does not exist");
        }
        triangles->InsertNextCell(3, ids);
    }
    vtkSmartPointer<vtkPolyData> data = vtkSmartPointer<vtkPolyData>::New();
    data->SetPoints(points);
    data->GetPointData()->SetNormals(normals);
    data->SetPolys(triangles);
    return data;
}

}} // namespace cv::surgtrack
