#include "labeled_surface.h"

#include <fresco/files_io.h>
#include <fresco/mesh.h>
#include <fresco/regions/regions.h>
#include <fresco/stage.h>

#include <fmt/format.h>

using namespace fresco;

namespace
{

class RegionsLabels final : public Stage
{
    Input<Mesh> mesh{this, "mesh", "The mesh to divide: the labeled one, or one made from it"};
    Input<Model> model{this, "model", optional, "A model whose materials have the regions' names, in place of files"};
    Input<Mesh> labeled{this, "labeled", optional,
                        "The mesh whose vertices the labels are for; needed for JSON, and for a PLY that lies elsewhere"};
    Output<Regions> regions{this, "regions", "The labels as regions; faces without one are the region 'other'"};
    Option<InputFile> path{this, "path", InputFile{}, formats({ply_format(), json_format()}),
                           "Labels: a PLY such as ScanNet's .labels.ply, or ScanNet's .aggregation.json"};
    Option<InputFile> segments{this, "segments", InputFile{}, formats({json_format()}),
                               "ScanNet's .segs.json, for an .aggregation.json"};
    Option<std::string> property{this, "property", "label",
                                 "Integer property of the PLY's vertices or faces that has the labels"};
    Option<std::string> naming{this, "naming", "nyu40", one_of({"nyu40", "numbers"}),
                               "Names of a PLY's labels: ScanNet's NYU40 classes, or the numbers themselves"};
    Option<double> within_cm{this, "within_cm", 5, range(0.01, 100), "Farthest from a labeled face that a face takes its label"};
    Option<double> least_covered{this, "least_covered", 0.8, range(0, 1),
                                 "Share of the mesh that must be as close to the labeled faces; less is another mesh's labels"};

    void check() const
    {
        check_mesh(*mesh, "the mesh on port 'mesh'");
        if (path->empty() != model.has_value())
            throw Error("set either 'path' to a file with labels, or the input 'model'");
        const bool is_json = path->path.extension() == ".json";
        if (is_json && (segments->empty() || !labeled.has_value()))
            throw Error(path->path.string() +
                        " labels the segments of a mesh: set 'segments' to the scene's .segs.json, and wire the "
                        "mesh that both are for to the input 'labeled'");
        if (!is_json && !segments->empty())
            throw Error("option \"segments\" is for a 'path' that ends in .aggregation.json");
        if (labeled.has_value())
            check_mesh(*labeled, "the mesh on port 'labeled'");
    }

    LabeledSurface surface() const
    {
        if (model.has_value())
        {
            check_model(*model, "the model on port 'model'");
            return surface_from_materials(*model);
        }
        if (path->path.extension() == ".json")
            return surface_from_segments(read_text_file(path->path), path->path.string(), read_text_file(segments->path),
                                         segments->path.string(), *labeled);
        return surface_from_ply(read_file(path->path), path->path.string(), *property,
                                *naming == "nyu40" ? Naming::nyu40 : Naming::numbers, labeled.has_value() ? &*labeled : nullptr);
    }

    void run(RunContext& run) override
    {
        check();
        const LabeledSurface from = surface();
        run.check_canceled();
        const CarriedLabels carried = carried_labels(from, *mesh, *within_cm / 100, run);
        run.report("covered_share", carried.covered_share);
        run.report("mean_distance_m", carried.mean_distance_m);
        if (carried.covered_share < *least_covered)
            throw Error(fmt::format("only {:.0f}% of the mesh on port 'mesh' is within {:g} cm of the labeled faces; expected at "
                                    "least {:.0f}%: these are labels of another mesh, or it was moved",
                                    100 * carried.covered_share, *within_cm, 100 * *least_covered));
        Regions result = regions_from(*mesh, from.names, carried.label_of_face);
        report_regions(result, *mesh, run);
        regions = std::move(result);
    }
};

}  // namespace

FRESCO_STAGE("regions.labels", RegionsLabels,
             "Divides a mesh by labels: of a PLY, of ScanNet's segmentation, or a model's materials")
