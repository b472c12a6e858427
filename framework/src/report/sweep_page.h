#pragma once

#include <string>
#include <vector>

/// \file The page that shows what a matrix came to: a picture or more of each combination, side by side.

namespace fresco::host
{

struct SweepPicture
{
    std::string file;  ///< Below the folder of results.
    std::string uri;   ///< A small copy as a data URI; empty: there is none, and the file itself is shown.
};

struct SweepCell
{
    std::string name;                 ///< "kitchen,waves"
    std::vector<std::string> values;  ///< In the order of the axes.
    std::string state;
    std::string error;  ///< Empty: none.
    double seconds = 0;
    std::string report;  ///< Its report.html, below the folder of results; empty: none.
    std::vector<SweepPicture> pictures;
    std::vector<std::string> files;  ///< Below the folder of results.
};

struct SweepPage
{
    std::string title;
    std::vector<std::string> axes;
    std::vector<SweepCell> cells;  ///< In the order of the combinations: the last axis running fastest.
    std::string note;              ///< Why pictures are not small copies; empty: they are.
};

/// One HTML file without scripts that fetches nothing but the results beside it, and these only where a picture has no copy or is
/// opened. With two axes or more a table whose columns are the last axis's values and whose rows the one's before; one table for
/// each combination of the others.
std::string sweep_html(const SweepPage& page);

}  // namespace fresco::host
