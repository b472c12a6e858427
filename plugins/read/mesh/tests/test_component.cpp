#include "catch.h"

#include <fresco/error.h>
#include <fresco/files_io.h>
#include <fresco/mesh.h>
#include <fresco/reader.h>
#include <fresco/testing.h>

using namespace fresco;

TEST_CASE("read.mesh: reads PLY and OBJ, refuses damage by name")
{
    const auto made = testing::make_from_plugin(FRESCO_PLUGIN_FILE, "read.mesh");
    auto* const reader = dynamic_cast<FileReader*>(made.get());
    REQUIRE(reader != nullptr);
    CHECK(reader->artifact() == "mesh");
    CHECK(reader->extensions() == std::vector<std::string>{".ply", ".obj"});

    const testing::TemporaryFolder folder;
    const auto obj = folder.path() / "room.obj";
    write_file(obj, "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n");
    const auto value = reader->read(obj);
    const auto& square = dynamic_cast<const Mesh&>(*value);
    CHECK(square.triangles == std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}});

    const auto ply = folder.path() / "room.ply";
    const auto bytes = to_ply(square);
    write_file(ply, bytes);
    CHECK(dynamic_cast<const Mesh&>(*reader->read(ply)).positions == square.positions);
    write_file(ply, std::span(bytes).first(bytes.size() - 3));
    CHECK_THROWS_WITH(reader->read(ply), Contains("room.ply") && Contains("cut"));
    CHECK_THROWS_AS(reader->read(folder.path() / "none.ply"), MissingInput);
    write_file(obj, "v 0 0 0\nv 3e38 0 0\nv 0 3e38 0\nf 1 2 3\n");
    CHECK_THROWS_WITH(reader->read(obj), Contains("room.obj: vertex 1 is more than 1e7 m from the origin"));
}
