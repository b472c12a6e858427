#pragma once

#include <fresco/component.h>
#include <fresco/frames.h>
#include <fresco/mesh.h>
#include <fresco/run_context.h>

#include <functional>
#include <vector>

namespace fresco
{

/// Closes holes of a scanned surface: the contract behind `mesh.close_holes`. A component of the stage that fuses depth pictures,
/// because that has them decoded.
class HoleCloser : public Component
{
  public:
    static constexpr std::string_view component_kind = "hole_closer";
    ~HoleCloser() override;

    /// The mesh with faces added; those that it has keep their numbers. \pre check_mesh. `measured`: frames with depth pictures,
    /// which show which holes are real openings; may be empty. `depth` reads one, in meters. Throws Error, Canceled.
    virtual Mesh closed(const Mesh& mesh, const std::vector<const Frame*>& measured,
                        const std::function<RasterF(const Frame&)>& depth, RunContext& run) const = 0;
};

}  // namespace fresco
