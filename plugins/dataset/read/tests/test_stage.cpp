#include "catch.h"

#include <fresco/dataset/dataset_files.h>
#include <fresco/dataset/manifest.h>
#include <fresco/files_io.h>
#include <fresco/frames.h>
#include <fresco/mesh.h>
#include <fresco/random.h>
#include <fresco/testing.h>
#include <fresco/uv_maps.h>

#include <algorithm>
#include <cmath>

using namespace fresco;
namespace fs = std::filesystem;

namespace
{

/// A dataset of two views of 20 x 16 at 8 and 20 px, made of noise; the second view has no depth picture. It has a style picture
/// only with texcoords of float32. Kept in memory too, to be compared with what is read.
struct MadeDataset
{
    explicit MadeDataset(dataset::UvType uv = dataset::UvType::float32)
    {
        manifest.uv = uv;
        manifest.heights_px = {8, 20};
        manifest.has_style = uv == dataset::UvType::float32;
        mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
        mesh.triangles = {{0, 1, 2}, {0, 1, 1}};
        mesh.texcoords = {{0, 0}, {1, 0}, {0, 1}, {0, 0}, {1, 0}, {1, 0}};
        mesh.texture_px = 512;
        mesh.offset_m.x = manifest.has_style ? 448'000 : 0;
        write("mesh.ply", to_ply(mesh));
        if (manifest.has_style)
            write("style.npy", dataset::to_npy(style = noise<std::uint8_t>(9, 7, 3, 256)));
        for (std::size_t i = 0; i < 2; ++i)
            add_view(i);
        save();
    }

    /// Writes the manifest as it now is.
    void save() const { write_file(root / "dataset.json", dataset::to_text(manifest)); }

    /// Writes a file, and its stamp to the manifest.
    void write(const std::string& name, const std::vector<std::byte>& bytes)
    {
        fs::create_directories((root / name).parent_path());
        manifest.files[name] = dataset::write_stamped(root / name, bytes);
    }

    void read() { testing::run_stage(FRESCO_PLUGIN_FILE, "dataset.read", Value::Map{{"path", root.string()}}, {}, out, run); }
    std::string error()
    {
        return fresco::testing::error_of([&] { read(); });
    }

    testing::TemporaryFolder folder;
    fs::path root = folder.path() / "room";
    fs::path out = folder.path() / "out";
    testing::TestRun run;
    Random random{3};
    dataset::Manifest manifest;
    Mesh mesh;
    Raster8 style;
    std::vector<Raster8> pictures;
    std::vector<Raster16> depths;
    std::vector<RasterF> uvs;  ///< Per view and height, as read back.

    template <class T>
    Raster<T> noise(int width, int height, int channels, std::int64_t below)
    {
        Raster<T> raster(width, height, channels);
        for (T& value : raster.values)
            value = static_cast<T>(random.below(below));
        return raster;
    }

    void add_view(std::size_t i)
    {
        dataset::View view;
        view.sequence = "seq";
        view.frame = "frame-" + std::to_string(i);
        view.number = static_cast<std::int64_t>(i);
        view.color.intrinsics = {20, 16, 15, 15, 10, 8};
        view.depth.intrinsics = {10, 8, 7, 7, 5, 4};
        view.sharpness = 7;
        pictures.push_back(noise<std::uint8_t>(20, 16, 3, 256));
        write(dataset::picture_name(i), dataset::to_npy(pictures.back()));
        if (i == 0)
        {
            view.depth_unit_m = 0.25;
            depths.push_back(noise<std::uint16_t>(10, 8, 1, 65536));
            write(dataset::sensor_depth_name(i), dataset::to_npy(depths.back()));
        }
        for (const int height : manifest.heights_px)
        {
            const int width = view.color.intrinsics.width_at(height);
            RasterF uv(width, height, 2);
            for (float& u : uv.values)
                u = static_cast<float>(random.uniform());
            const bool is_uint16 = manifest.uv == dataset::UvType::uint16;
            write(dataset::map_name(i, "uv", height), is_uint16 ? dataset::to_npy(dataset::quantized(uv)) : dataset::to_npy(uv));
            uvs.push_back(is_uint16 ? dataset::restored(dataset::quantized(uv)) : uv);
            write(dataset::map_name(i, "valid", height), dataset::to_npy(Raster8(width, height, 1, 1)));
            write(dataset::map_name(i, "depth", height), dataset::to_npy(RasterF(width, height, 1, 1.5F)));
            write(dataset::map_name(i, "cosine", height), dataset::to_npy(RasterF(width, height, 1, 0.5F)));
            write(dataset::map_name(i, "color", height), dataset::to_npy(noise<std::uint8_t>(width, height, 3, 256)));
            view.valid_pixels.push_back(width * height);
        }
        manifest.views.push_back(view);
    }
};

bool is_near(const RasterF& a, const RasterF& b, double margin)
{
    return std::ranges::equal(a.values, b.values, [&](double x, double y) { return std::abs(x - y) <= margin; });
}

}  // namespace

TEST_CASE("everything that a dataset holds is read as it was written, without a codec")
{
    for (const auto uv : {dataset::UvType::float32, dataset::UvType::uint16})
    {
        MadeDataset made(uv);
        const fs::path& out = made.out;
        made.read();

        const auto maps = UvMaps::load({out / "uvmaps", out});
        CHECK(maps->heights_px == std::vector<int>{8, 20});
        CHECK(maps->texture_px == 512);
        CHECK(maps->uv_bits == (uv == dataset::UvType::uint16 ? 16 : 22));
        REQUIRE(maps->views.size() == 2);
        for (std::size_t i = 0; i < 2; ++i)
        {
            CHECK(maps->views[i].frame == "frame-" + std::to_string(i));
            CHECK(maps->views[i].camera == made.manifest.views[i].color);
            CHECK(maps->views[i].valid_pixels == std::vector<std::int64_t>{10 * 8, 25 * 20});
            for (std::size_t level = 0; level < 2; ++level)
            {
                const UvMap map = maps->load_map(i, level);
                // As near as the store's steps come: those of uint16, or the finest.
                CHECK(is_near(map.uv, made.uvs[2 * i + level], uv == dataset::UvType::uint16 ? 0 : 1.8e-7));
                CHECK(map.depth == RasterF(map.uv.width, map.uv.height, 1, 1.5F));
                CHECK(is_near(map.cosine, RasterF(map.uv.width, map.uv.height, 1, 0.5F), 0.00197));
                CHECK(map.valid == Raster8(map.uv.width, map.uv.height, 1, 1));
            }
        }
        const auto frames = Frames::load({out / "frames", out});
        REQUIRE(frames->frames.size() == 2);
        CHECK(frames->offset_m == made.mesh.offset_m);
        CHECK(frames->frames[1].name == "frame-1");
        CHECK(frames->frames[1].depth == made.manifest.views[1].depth);
        CHECK(load_color(frames->frames[0], nullptr) == made.pictures[0]);
        CHECK(load_color(frames->frames[1], nullptr) == made.pictures[1]);
        CHECK(load_depth_steps(frames->frames[0], nullptr) == made.depths[0]);
        CHECK(frames->frames[0].depth_unit_m == 0.25);
        CHECK(frames->frames[1].depth_picture.empty());
        CHECK(Image::load({out / "style", out})->pixels == made.style);  // Without a style, the image has no pixels.
        CHECK(made.run.messages.size() == (made.manifest.has_style ? 0 : 1));
        const auto mesh = Mesh::load({out / "mesh", out});
        CHECK(mesh->triangles == made.mesh.triangles);
        CHECK(mesh->texcoords == made.mesh.texcoords);
        // The manifest stamps all files: only it decides whether the result is still the right one.
        CHECK(made.run.files_read == std::vector<fs::path>{made.root / "dataset.json"});
    }
}

TEST_CASE("files that are not as the manifest lists them are named")
{
    // Its files after `damage`, in a dataset of its own.
    const auto error_after = [](const auto& damage)
    {
        MadeDataset made;
        damage(made);
        return made.error();
    };
    const char* name = "views/000001/cosine_20.npy";
    CHECK_THAT(error_after([&](const MadeDataset& it) { fs::remove(it.root / name); }),
               Contains(name) && Contains("is missing; copy the dataset again"));
    CHECK_THAT(error_after([&](const MadeDataset& it) { fs::resize_file(it.root / name, 1000); }),
               Contains(name) && Contains("has 1000 bytes; dataset.json lists"));
    // A single bit, in each kind of file, those that are not copied too.
    for (const char* file :
         {"mesh.ply", "style.npy", "views/000000/uv_8.npy", "views/000000/depth_20.npy", "views/000001/valid_8.npy",
          "views/000001/color_8.npy", "views/000001/color.npy", "views/000000/sensor_depth.npy"})
    {
        const auto change_a_bit = [&](const MadeDataset& it)
        {
            auto bytes = read_file(it.root / file);
            bytes[bytes.size() - 3] ^= std::byte{1};
            write_file(it.root / file, bytes);
        };
        CHECK_THAT(error_after(change_a_bit), Contains(file) && Contains("its contents differ from dataset.json"));
    }
    CHECK_THAT(error_after([](const MadeDataset& it) { fs::remove(it.root / "dataset.json"); }),
               Contains("room: dataset.json is missing"));
    CHECK_THAT(error_after(
                   [](MadeDataset& it)
                   {
                       it.manifest.files["extra/notes.txt"] = {4, content_hash(std::string_view("note"))};
                       it.save();
                   }),
               Contains("extra/notes.txt: file is missing"));
}

TEST_CASE("files of the wrong kind, shape or range are named though their stamps are right")
{
    const auto refused = [](const std::string& name, const std::vector<std::byte>& bytes, const char* word)
    {
        MadeDataset made;
        made.write(name, bytes);
        made.save();
        CHECK_THAT(made.error(), Contains(name) && Contains(word));
    };
    const char* uv = "views/000001/uv_20.npy";
    refused(uv, dataset::to_npy(RasterF(20, 25, 2)), "25 x 20 x 2; expected 20 x 25 x 2");
    refused(uv, dataset::to_npy(Raster16(25, 20, 2)), "expected float32");
    refused(uv, dataset::to_npy(RasterF(25, 20, 2, 1.01F)), "holds 1.01; expected a number from 0 to 1");
    refused(uv, dataset::to_npy(RasterF(25, 20, 2, std::nanf(""))), "pixel (0, 0) holds nan");
    auto cut = dataset::to_npy(RasterF(25, 20, 2));
    cut.resize(cut.size() - 8);
    refused(uv, cut, "the shape asks for 4000 bytes of data, the file has 3992");
    const std::string view = "views/000000/";
    refused(view + "depth_8.npy", dataset::to_npy(RasterF(10, 8)), "pixel (0, 0) is valid");
    refused(view + "cosine_8.npy", dataset::to_npy(RasterF(10, 8, 1, 2)), "pixel (0, 0) holds 2");
    refused(view + "valid_8.npy", dataset::to_npy(Raster8(10, 8, 1, 3)), "0 or 1");
    refused(view + "valid_8.npy", dataset::to_npy(Raster8(10, 8)), "0 valid pixels; expected 80");
    refused(view + "color_8.npy", dataset::to_npy(Raster8(10, 8, 4)), "8 x 10 x 3");
    refused(view + "color.npy", dataset::to_npy(Raster8(10, 8, 3)), "expected 16 x 20 x 3");
    refused(view + "sensor_depth.npy", dataset::to_npy(Raster8(10, 8)), "expected uint16");
    refused("style.npy", dataset::to_npy(RasterF(10, 8)), "expected a picture");
    refused("mesh.ply", cut, "");
    Mesh plain;
    plain.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    plain.triangles = {{0, 1, 2}};
    refused("mesh.ply", to_ply(plain), "the mesh has no texcoords");
}

TEST_CASE("a manifest that is cut or changed is refused or gives a dataset that can be used")
{
    MadeDataset made;
    const std::string whole = read_text_file(made.root / "dataset.json");
    Random random(9);
    for (std::size_t i = 0; i < 20; ++i)
    {
        write_file(made.root / "dataset.json", whole.substr(0, i * whole.size() / 20));
        CHECK_FALSE(made.error().empty());
        std::string changed = whole;
        changed[static_cast<std::size_t>(random.below(std::ssize(whole)))] ^= static_cast<char>(1 + random.below(127));
        write_file(made.root / "dataset.json", changed);
        CHECK_NOTHROW(made.error());
    }
}
