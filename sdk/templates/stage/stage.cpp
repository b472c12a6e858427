#include "my_plugin.h"

#include <fresco/mesh.h>
#include <fresco/option.h>
#include <fresco/stage.h>

namespace
{

class MyPlugin final : public fresco::Stage
{
    // Members declare what a pipeline can say: ports, and options with their defaults and limits. `fresco describe my.plugin`
    // shows them, `fresco check` checks them, and what they hold decides whether a stored result can be used again.
    fresco::Input<fresco::Mesh> mesh{this, "mesh", "Triangle mesh"};
    fresco::Output<fresco::Mesh> scaled{this, "scaled", "The mesh at another size"};
    fresco::Option<double> factor{this, "factor", 1.0, fresco::range(1e-3, 1e3), "Size of the result over that of the mesh"};

    void run(fresco::RunContext& run) override
    {
        run.check_canceled();  // In a longer stage: every second or so.
        scaled = my_plugin::scaled(*mesh, *factor);
        run.report("vertices", mesh->positions.size());
    }
};

}  // namespace

FRESCO_STAGE("my.plugin", MyPlugin, "Scales a mesh about its middle")
