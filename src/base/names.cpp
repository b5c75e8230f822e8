// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "opencv2/surgtrack/names.hpp"
#include <cctype>

namespace cv { namespace surgtrack {

//! Letters to put in, take out or change until the names are the same, small or capital. (Levenshtein)
static int difference(const String& a, const String& b)
{
    std::vector<int> row(b.size() + 1);
    for (size_t j = 0; j <= b.size(); j++) row[j] = (int)j;
    for (size_t i = 0; i < a.size(); i++)
    {
        int before = row[0];   // of the row above
        row[0] = (int)i + 1;
        for (size_t j = 0; j < b.size(); j++)
        {
            const int changed = before + (std::tolower((uchar)a[i]) != std::tolower((uchar)b[j]));
            before = row[j + 1];
            row[j + 1] = std::min(changed, 1 + std::min(before, row[j]));
        }
    }
    return row[b.size()];
}

String closestName(const String& name, const std::vector<String>& names)
{
    const String* best = 0;
    const String lastOfName = name.substr(name.rfind('.') + 1);   // all of it if there is no dot
    int least = std::max(1, (int)name.size() / 3);   // what differs by more is another word
    for (size_t i = 0; i < names.size(); i++)
    {
        const int last = 1 + difference(lastOfName, names[i].substr(names[i].rfind('.') + 1)), differs = std::min(difference(name, names[i]), last);
        if (differs > least || (best && differs == least)) continue;
        least = differs;
        best = &names[i];
    }
    return best ? *best : String();
}

String didYouMean(const String& name, const std::vector<String>& names)
{
    const String closest = closestName(name, names);
    return closest.empty() ? closest : ", did you mean '" + closest + "'?";
}

}} // namespace cv::surgtrack
