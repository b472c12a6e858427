#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/image.h>
#include <fresco/image_io.h>
#include <fresco/stage.h>

namespace
{

class SavePicture final : public fresco::Stage
{
    fresco::Input<fresco::Image> image{this, "image", "Any picture"};
    fresco::Output<fresco::Files> files{this, "files", "The picture"};
    fresco::Option<fresco::OutputName> path{this, "path", fresco::OutputName{"picture.png"}, fresco::extensions({".png"}),
                                            "Output path below --out"};
    fresco::Slot<fresco::ImageIo> images{this, "Encodes the picture"};

    void run(fresco::RunContext& run) override
    {
        const auto file = files.folder().path / path->path;
        std::filesystem::create_directories(file.parent_path());
        const auto png = images->encode_png(image->pixels);
        fresco::write_file(file, png);
        run.report("bytes", png.size());
        fresco::Files written;
        written.names = {path->path};
        files = std::move(written);
    }
};

}  // namespace

FRESCO_STAGE("example.save_picture", SavePicture, "Writes a picture as PNG")
