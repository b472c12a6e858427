// write_uv_maps FOLDER: packed uv maps of every sort, and what the SDK reads of them as NPY.
#include "uv_map_samples.h"

#include <fresco/files_io.h>
#include <fresco/npy.h>
#include <fresco/uv_maps.h>

namespace
{

void write_all(const std::filesystem::path& folder)
{
    std::size_t count = 0;
    for (const auto& [name, map] : all_uv_maps())
        for (const int uv_bits : {16, 17, 18, 22})
        {
            const std::string stem = std::to_string(count++);
            const auto bytes = fresco::pack_uv_map(map, uv_bits, name);
            fresco::write_file(folder / (stem + ".uvmap"), bytes);
            const auto back = fresco::unpack_uv_map(bytes, map.valid.width, map.valid.height, name);
            fresco::write_npy(folder / (stem + ".uv.npy"), back.uv);
            fresco::write_npy(folder / (stem + ".depth.npy"), back.depth);
            fresco::write_npy(folder / (stem + ".cosine.npy"), back.cosine);
            fresco::write_npy(folder / (stem + ".valid.npy"), back.valid);
        }
}

}  // namespace

int main(int /*argc*/, char** argv)
{
    write_all(argv[1]);
}
