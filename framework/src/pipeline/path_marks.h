#pragma once

#include "pipeline/pipeline_types.h"

#include <filesystem>
#include <string>

/// \file Finds the component that a folder or file is for, by the marks that plugins declare: `auto` of a slot that is ByMarks.
/// The host knows no layout of a folder itself.

namespace fresco::host
{

struct MarkedChoice
{
    std::string type{};     ///< Empty where `auto` has come to nothing.
    std::string problem{};  ///< Says what was looked for and what was found, component by component, and what may be meant.
    bool several = false;   ///< The problem is that several components fit.
};

/// The component for a slot whose marks fit a folder or file; of several, the one that is declared to go before all others.
/// `named`: the type that the pipeline names, whose marks the path must have then; empty: `auto`.
MarkedChoice choose_by_marks(const std::filesystem::path& path, const OptionDeclaration& slot, const std::string& named,
                             TypeTable& types);

/// "rgb.txt and poses.txt or poses", ".sens files"; each entry that `folder` has with "(found)".
std::string marks_text(const Marks& marks, const std::filesystem::path& folder = {});

}  // namespace fresco::host
