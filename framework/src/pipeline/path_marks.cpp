#include "pipeline/path_marks.h"
#include "base/common.h"
#include "base/glob.h"
#include "base/text.h"
#include <fresco/wording.h>

#include <algorithm>

namespace fresco::host
{
namespace
{

using Names = std::vector<std::string>;
using Components = std::vector<KnownType>;

bool fits(const Marks& marks, const fs::path& path)
{
    const auto is_there = [&](const std::string& entry)
    { return std::ranges::any_of(split(entry, '|'), [&](const std::string& name) { return has_entry(path, name); }); };
    if (std::error_code failure; fs::is_directory(path, failure))
        return !marks.contains.empty() && std::ranges::all_of(marks.contains, is_there);
    const Names extensions = all_extensions(marks.formats);
    return std::ranges::find(extensions, lower_extension(path)) != extensions.end();
}

Components fitting(const Components& all, const fs::path& path)
{
    Components found = all;
    std::erase_if(found, [&](const KnownType& type) { return !fits(type.declaration->marks, path); });
    return found;
}

Names names_of(const Components& components)
{
    return each(components, [](const KnownType& type) { return type.description->type; });
}

bool goes_before(const KnownType& one, const KnownType& other)
{
    const Names& before = one.declaration->marks.before;
    return one.description == other.description || std::ranges::find(before, "*") != before.end() ||
           std::ranges::find(before, other.description->type) != before.end();
}

/// Says what each component looks for, on a line of its own.
std::string looked_for(const Components& components, const fs::path& path)
{
    std::string text;
    for (const KnownType& type : components)
        if (const std::string marks = marks_text(type.declaration->marks, path); !marks.empty())
            text += "\n  " + type.description->type + " looks for " + marks;
    return text;
}

}  // namespace

MarkedChoice choose_by_marks(const fs::path& path, const OptionDeclaration& slot, const std::string& named, TypeTable& types)
{
    Components all;
    for (const TypeDescription* type : types.catalog().types(slot.component_kind))
        if (const KnownType known = types.find(type->type, slot.component_kind))
            all.push_back(known);
    const Components found = fitting(all, path);
    const std::string shown = "'" + path.string() + "'";
    if (!named.empty())
    {
        Components own = all;
        std::erase_if(own, [&](const KnownType& type) { return type.description->type != named; });
        if (own.empty() || marks_text(own[0].declaration->marks).empty() || fits(own[0].declaration->marks, path))
            return {named};
        const std::string others = join(names_of(found)) + (found.size() == 1 ? " does" : " do");
        return {named, named + " does not fit " + shown + (found.empty() ? "" : "; " + others) + looked_for(own, path)};
    }
    Components first = found;
    std::erase_if(first, [&](const KnownType& one)
                  { return !std::ranges::all_of(found, [&](const KnownType& other) { return goes_before(one, other); }); });
    if (first.size() == 1)
        return {first[0].description->type};
    if (!found.empty())
        return {"",
                "several components of kind " + slot.component_kind + " fit " + shown + "; name one, " + slot.name + ": " +
                    join(names_of(found), " or ") + looked_for(found, path),
                true};
    return {"", "no " + slot.component_kind + " fits " + shown + looked_for(all, path)};
}

std::string marks_text(const Marks& marks, const fs::path& folder)
{
    Names entries;
    for (const std::string& entry : marks.contains)
    {
        Names names = split(entry, '|');
        for (std::string& name : names)
            if (!folder.empty() && has_entry(folder, name))
                name += " (found)";
        entries.push_back(join(names, " or "));
    }
    const std::string files = marks.formats.empty() ? "" : join(all_extensions(marks.formats), " or ") + " files";
    return join(entries) + (entries.empty() || files.empty() ? "" : ", or ") + files;
}

}  // namespace fresco::host
