#include "model_samples.h"

#include <fresco/files_io.h>
#include <fresco/mesh.h>
#include <fresco/reader.h>
#include <fresco/testing.h>

#include <catch2/catch.hpp>

using namespace fresco;

TEST_CASE("read.glb reads the shape of a GLB, as scan.mesh does")
{
    const auto made = testing::make_from_plugin(FRESCO_PLUGIN_FILE, "read.glb");
    auto* const reader = dynamic_cast<FileReader*>(made.get());
    REQUIRE(reader != nullptr);
    CHECK(reader->artifact() == "mesh");
    CHECK(reader->extensions() == std::vector<std::string>{".glb"});
    const testing::TemporaryFolder folder;
    const auto file = folder.path() / "room.glb";
    const auto bytes = model_samples::TriangleSample().finished().glb();
    write_file(file, bytes);
    const auto value = reader->read(file);
    const auto& mesh = dynamic_cast<const Mesh&>(*value);
    CHECK(mesh.triangles == std::vector<Triangle>{{0, 1, 2}});
    CHECK(mesh.positions.size() == 3);
    write_file(file, std::span(bytes).first(bytes.size() - 3));
    CHECK_THROWS_WITH(reader->read(file), Catch::Contains("room.glb"));
}
