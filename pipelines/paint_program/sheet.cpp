#include "sheet.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/value.h>

#include <map>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace fresco::paint
{
namespace
{

namespace fs = std::filesystem;

constexpr int tile_px = 640;
constexpr int caption_px = 96;
constexpr int gap_px = 12;

/// How much there is to see: the share of the picture with surface, which elsewhere is black, times how much its brightness
/// varies.
double shown_in(const cv::Mat& view)
{
    cv::Mat gray, mean, deviation;
    cv::cvtColor(view, gray, cv::COLOR_BGR2GRAY);
    cv::meanStdDev(gray, mean, deviation, gray > 0);
    return deviation.at<double>(0) * cv::countNonZero(gray) / static_cast<double>(view.total());
}

/// Puts a picture on the sheet, within a box of these sides; its width there.
int put(cv::Mat& sheet, const cv::Mat& picture, cv::Rect box)
{
    const double scale = std::min(box.width / static_cast<double>(picture.cols), box.height / static_cast<double>(picture.rows));
    cv::Mat small;
    cv::resize(picture, small, {}, scale, scale, cv::INTER_AREA);
    small.copyTo(sheet(cv::Rect(box.tl(), small.size())));
    return small.cols;
}

}  // namespace

fs::path write_sheet(const fs::path& folder)
{
    const Value data = parse_json(read_text_file(folder / "sweep.json"), "sweep.json");
    // By a view's path below a combination's folder: its pictures in all of them by their names, and what they show together.
    std::map<std::string, std::vector<std::pair<const Value*, cv::Mat>>> views;
    std::map<std::string, double> shown;
    for (const Value& cell : data.at("combinations").as_list())
        for (const Value& file : cell.at("files").as_list())
            if (const fs::path path = file.as_string(); path.parent_path().filename() == "views")
                if (const cv::Mat view = cv::imread((folder / path).string()); !view.empty())
                {
                    const std::string own = path.lexically_relative(cell.at("name").as_string()).string();
                    shown[own] += shown_in(view);
                    views[own].emplace_back(&cell, view);
                }
    const auto best = std::ranges::max_element(shown, {}, [](const auto& entry) { return entry.second; });
    if (best == shown.end())
        return {};
    std::map<std::string, std::string> styles;
    for (const Value& stage : data.at("stages").as_list())
        for (const Value& input : stage.at("inputs").as_list())
            if (const Value* file = input.find("file"))
                styles[stage.at("name").as_string()] = file->as_string();
    const auto& chosen = views[best->first];
    const int count = static_cast<int>(chosen.size());
    const int columns = static_cast<int>(std::ceil(std::sqrt(count)));
    const cv::Mat& first = chosen.front().second;
    const int view_px = std::min(tile_px, tile_px * first.rows / first.cols);
    const int row_px = view_px + caption_px + gap_px;
    cv::Mat sheet((count + columns - 1) / columns * row_px + gap_px, columns * (tile_px + gap_px) + gap_px, CV_8UC3,
                  cv::Scalar::all(255));
    for (int i = 0; i < count; ++i)
    {
        const auto& [cell, view] = chosen[static_cast<std::size_t>(i)];
        cv::Point at{gap_px + i % columns * (tile_px + gap_px), gap_px + i / columns * row_px};
        put(sheet, view, {at.x, at.y, tile_px, view_px});
        at.y += view_px + 4;
        for (const Value& stage : cell->at("stages").as_list())
            if (const auto style = styles.find(stage.as_string()); style != styles.end())
                if (const cv::Mat picture = cv::imread(style->second); !picture.empty() && at.x % (tile_px + gap_px) == gap_px)
                    at.x += put(sheet, picture, {at.x, at.y, 2 * caption_px, caption_px - 8}) + gap_px;
        cv::putText(sheet, cell->at("name").as_string(), {at.x, at.y + caption_px / 2}, cv::FONT_HERSHEY_SIMPLEX, 0.8,
                    cv::Scalar::all(40), 2, cv::LINE_AA);
    }
    std::vector<unsigned char> bytes;
    cv::imencode(".jpg", sheet, bytes, {cv::IMWRITE_JPEG_QUALITY, 90});
    write_durable_file(folder / "sheet.jpg", std::as_bytes(std::span(bytes)));
    return folder / "sheet.jpg";
}

}  // namespace fresco::paint
