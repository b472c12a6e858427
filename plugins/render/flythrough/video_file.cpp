#include "video_file.h"

#include <fresco/error.h>

#include <opencv2/imgproc.hpp>

#include <fmt/format.h>
#include <utility>
#include <vector>

VideoFile::VideoFile(std::filesystem::path file, int width, int height, double fps) : file_(std::move(file))
{
    const std::vector<std::string> codecs =
        file_.extension() == ".webm" ? std::vector<std::string>{"VP90", "VP80"} : std::vector<std::string>{"avc1", "mp4v"};
    for (const std::string& codec : codecs)
    {
        const int fourcc = cv::VideoWriter::fourcc(codec[0], codec[1], codec[2], codec[3]);
        try
        {
            if (writer_.open(file_.string(), cv::CAP_FFMPEG, fourcc, fps, cv::Size(width, height)))
            {
                codec_ = codec;
                return;
            }
        }
        catch (const cv::Exception&)
        {
            continue;
        }
    }
    throw fresco::Error(file_.filename().string() + ": OpenCV's FFmpeg has no encoder for this format; set format: png");
}

void VideoFile::add(const fresco::Raster8& picture)
{
    const cv::Mat rgb(picture.height, picture.width, CV_8UC3, const_cast<std::uint8_t*>(picture.values.data()));
    cv::Mat bgr;
    cv::cvtColor(rgb, bgr, cv::COLOR_RGB2BGR);
    writer_.write(bgr);
    ++added_;
}

void VideoFile::close()
{
    writer_.release();
    cv::VideoCapture written(file_.string(), cv::CAP_FFMPEG);
    std::size_t found = 0;
    while (written.isOpened() && found <= added_ && written.grab())
        ++found;
    if (found != added_)
        throw fresco::Error(
            fmt::format("{}: only {} of {} video frames were written; is the disk full?", file_.string(), found, added_));
}
