// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include <cstdlib>
#include "files/joint_names.hpp"
#include "files/text_file.hpp"
#include "lab/import/import_tool.hpp"

// importHandEye(): a 4x4 matrix as other programs write it.

namespace cv { namespace surgtrack {

namespace {

const char* const EXPECTED = "expected the 4x4 matrix camera_T_base [m]: of cv::FileStorage, as lists in YAML or JSON, as base-frame.transform of the "
                             "dVRK's registration, or as four lines of numbers";

void appendNumbers(const FileNode& node, std::vector<double>& numbers)
{
    if (node.isInt() || node.isReal())
        numbers.push_back((double)node);
    else if (node.isMap() && !node["data"].empty())
        appendNumbers(node["data"], numbers);
    else
        for (FileNodeIterator it = node.begin(); node.isSeq() && it != node.end(); ++it)
            appendNumbers(*it, numbers);
}

//! camera_T_base, transform, or that in base-frame, whatever its form.
std::vector<double> ofMap(const FileNode& root)
{
    std::vector<double> numbers;
    const char* const keys[] = { "camera_T_base", "base-frame", "base_frame", "transform" };
    for (int i = 0; i < 4 && numbers.empty(); i++)
        if (!root[keys[i]].empty())
            appendNumbers(root[keys[i]].isMap() && !root[keys[i]]["transform"].empty() ? root[keys[i]]["transform"] : root[keys[i]], numbers);
    return numbers;
}

//! Lines of numbers, between commas, semicolons or spaces; brackets are passed over.
std::vector<double> ofText(String text)
{
    for (size_t i = 0; i < text.size(); i++)
        if (String("[](),;\t\r\n").find(text[i]) != String::npos)
            text[i] = ' ';
    std::istringstream words(text);
    words.imbue(std::locale::classic());
    std::vector<double> numbers;
    double number;
    while (words >> number)
        numbers.push_back(number);
    return words.eof() ? numbers : std::vector<double>();
}

FileNode firstMap(const String& filename, FileStorage& storage)
{
    const String text = readTextFile(filename);
    const size_t start = text.find_first_not_of(" \t\r\n");
    const bool plain = start != String::npos && text[start] != '{' && text[start] != '<' && text.compare(0, 5, "%YAML") != 0;
    storage = plain ? openYaml(filename) : parseStorage(filename, text);
    return storage.root();
}

} // namespace

Matx44d importHandEye(const String& filename)
{
    if (endsWith(filename, "-registration-dVRK.json"))
        importError(filename, "has the camera's axes as the dVRK's console, expected the file ...-registration-open-cv.json beside it");
    std::vector<double> numbers = ofText(readTextFile(filename));
    if (numbers.empty())
    {
        FileStorage storage;
        numbers = ofMap(firstMap(filename, storage));
    }
    if (numbers.size() == 12)
        for (int i = 0; i < 4; i++)
            numbers.push_back(i == 3);
    if (numbers.size() != 16)
        importError(filename, EXPECTED);
    const Matx44d T(numbers.data());
    if (!isRigid(T))
        importError(filename, "expected a rigid transform: finite, rotation orthonormal and right-handed, last row 0 0 0 1");
    const double distance = norm(Vec3d(T(0, 3), T(1, 3), T(2, 3)));
    if (distance > 10)
        importError(filename, format("the base is %.4g m away from the camera, expected metres, not millimetres", distance));
    return T;
}

}} // namespace cv::surgtrack
