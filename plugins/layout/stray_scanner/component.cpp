#include "odometry.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/image_io.h>
#include <fresco/recordings/confidence.h>
#include <fresco/recordings/layout.h>

#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include <algorithm>
#include <exception>
#include <fmt/format.h>
#include <mutex>
#include <utility>

namespace
{

namespace fs = std::filesystem;
using namespace fresco::recordings;

constexpr int jpeg_quality = 95;

cv::VideoCapture opened(const fs::path& file)
{
    cv::VideoCapture video(file.string(), cv::CAP_FFMPEG);
    if (!video.isOpened())
        throw fresco::Error(file.string() + ": OpenCV's FFmpeg cannot read this video: it is damaged, or in a format that this "
                                            "FFmpeg lacks");
    // The poses are for the sensor's pictures, as they are stored.
    video.set(cv::CAP_PROP_ORIENTATION_AUTO, 0);
    return video;
}

class StrayScannerLayout final : public Layout
{
  public:
    fresco::Marks marks() const override { return {.contains = {"odometry.csv", "camera_matrix.csv", "rgb.mp4"}}; }

  private:
    fresco::Option<int> min_confidence = min_confidence_option(this);

    Recording list(fresco::RunContext& run) override
    {
        const auto odometry = path() / "odometry.csv", matrix = path() / "camera_matrix.csv";
        rows_ = stray_scanner::parse_odometry(recorded_text(odometry, run), odometry.string());
        const auto camera = stray_scanner::parse_camera_matrix(recorded_text(matrix, run), matrix.string());
        run.reads_file(video());
        const auto capture = opened(video());
        camera_ = intrinsics_for(
            camera, PixelCenter::half,
            {static_cast<int>(capture.get(cv::CAP_PROP_FRAME_WIDTH)), static_cast<int>(capture.get(cv::CAP_PROP_FRAME_HEIGHT))},
            video());
        run_ = &run;
        count_pictures();
        Recording recording{.files = "a row of odometry.csv, depth/N.png and confidence/N.png"};
        for (const char* pictures : {"depth/*.png", "confidence/*.png"})
            looks_for(path() / pictures, run);
        for (std::size_t i = hidden_; i < rows_.size(); ++i)
        {
            RecordedView view;
            view.sequence = "scan";
            view.name = rows_[i].frame;
            view.number = static_cast<long>(i);
            view.depth = path() / "depth" / (view.name + ".png");
            view.source = rows_[i].source;
            if (fs::exists(confidence_of(view)))
                run.reads_file(confidence_of(view));
            recording.views.push_back(std::move(view));
        }
        forget_missing_depth(recording.views);
        return recording;
    }

    bool locate(RecordedView& view, fresco::RunContext& /*run*/) override
    {
        const auto& row = rows_[static_cast<std::size_t>(view.number)];
        if (!row.world_from_camera)
            return false;
        view.world_from_camera = *row.world_from_camera;
        view.camera = row.camera.value_or(camera_);
        view.camera.width = camera_.width;
        view.camera.height = camera_.height;
        used_.push_back(view.number);
        return true;
    }

    bool unpack(RecordedView& view, const fs::path& folder) const override
    {
        std::call_once(is_written_,
                       [&]
                       {
                           try
                           {
                               write_pictures(folder);
                           }
                           catch (...)
                           {
                               failure_ = std::current_exception();
                           }
                       });
        if (failure_)
            std::rethrow_exception(failure_);
        view.color = color_of(view.name, folder);
        write_sure_depth(view, confidence_of(view), *min_confidence, codec(), folder);
        return true;
    }

    /// The app writes a row with each picture, and counts pictures in the video's times, not seconds. Its first picture has a
    /// time before the beginning, so players, and some versions of FFmpeg, hide it. Only counting shows which picture is whose.
    void count_pictures()
    {
        auto capture = opened(video());
        std::size_t count = 0;
        for (; capture.grab(); ++count)
            run_->check_canceled();
        hidden_ = rows_.size() - count;
        if (count == 0 || (hidden_ != 0 && hidden_ != 1))
            throw fresco::Error(
                fmt::format("{}: {} pictures, and odometry.csv has {} rows; expected one for each row, or without the "
                            "first: the video is cut, or was converted; copy the recording again",
                            video().string(), count, rows_.size()));
    }

    /// Writes the used pictures of the video, which is decoded from its beginning: the pictures of a phone's video refer to each
    /// other.
    void write_pictures(const fs::path& folder) const
    {
        auto capture = opened(video());
        cv::Mat bgr, rgb;
        auto next = used_.begin();
        for (auto at = static_cast<long>(hidden_); next != used_.end() && capture.grab(); ++at)
        {
            run_->check_canceled();
            if (at != *next)
                continue;
            capture.retrieve(bgr);
            cv::cvtColor(bgr, rgb, cv::COLOR_BGR2RGB);
            fresco::Raster8 picture(rgb.cols, rgb.rows, 3);
            std::copy(rgb.datastart, rgb.dataend, picture.values.begin());
            fresco::write_file(color_of(rows_[static_cast<std::size_t>(at)].frame, folder),
                               codec().encode_jpeg(picture, jpeg_quality));
            ++next;
        }
    }

    fs::path video() const { return path() / "rgb.mp4"; }
    fs::path confidence_of(const RecordedView& view) const { return path() / "confidence" / (view.name + ".png"); }
    static fs::path color_of(const std::string& name, const fs::path& folder) { return folder / (name + ".color.jpg"); }

    std::vector<stray_scanner::Row> rows_;
    fresco::Intrinsics camera_;
    std::vector<long> used_;
    std::size_t hidden_ = 0;  ///< Rows before that of the video's first picture.
    const fresco::RunContext* run_ = nullptr;
    mutable std::once_flag is_written_;
    mutable std::exception_ptr failure_;
};

}  // namespace

FRESCO_COMPONENT("layout.stray_scanner", StrayScannerLayout, fresco::recordings::Layout,
                 "Recordings of Stray Scanner (iPhone, iPad)")
