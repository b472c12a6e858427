// Reads a text file with a number as a picture of that value, and writes pictures as text. 13 crashes it, 14 is broken, 15 takes
// as long as a file "open" lies in the working folder.
#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/image_io.h>
#include <fresco/stage.h>

#include <chrono>
#include <csignal>
#include <span>
#include <string>
#include <thread>

namespace
{

class TextImages final : public fresco::ImageIo
{
  public:
    fresco::ImageHeader header(const std::filesystem::path&) const override { return {960, 480}; }
    fresco::Raster8 read_rgb(const std::filesystem::path& file) const override
    {
        const int value = std::stoi(fresco::read_text_file(file));
        if (value == 13)
            std::raise(SIGSEGV);
        if (value == 14)
            throw fresco::Error(file.string() + ": is cut");
        const std::filesystem::path open = std::filesystem::current_path() / "open";
        if (value == 15)
            fresco::write_file(open, std::string_view());
        while (value == 15 && std::filesystem::exists(open))
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
        return {960, 480, 3, static_cast<std::uint8_t>(value)};
    }
    fresco::Raster16 read_depth(const std::filesystem::path& file) const override { throw fresco::Error(file.string()); }
    std::vector<std::byte> encode_png(const fresco::Raster8& image) const override { return encode_jpeg(image, 0); }
    std::vector<std::byte> encode_png(const fresco::Raster16&) const override { return {}; }
    std::vector<std::byte> encode_jpeg(const fresco::Raster8& image, int) const override
    {
        const std::string text =
            std::to_string(image.width) + "x" + std::to_string(image.height) + " of " + std::to_string(image.values.at(0));
        const auto bytes = std::as_bytes(std::span(text));
        return {bytes.begin(), bytes.end()};
    }
};
FRESCO_COMPONENT("image.test", TextImages, fresco::ImageIo, "Text for pictures")

}  // namespace
