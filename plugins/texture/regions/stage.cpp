#include <fresco/regions/regions.h>

#include <fresco/mesh.h>
#include <fresco/part_names.h>
#include <fresco/stage.h>
#include <fresco/texture.h>
#include <fresco/texturing/surface_fill.h>
#include <fresco/texturing/texel_faces.h>
#include <fresco/texturing/texture_pictures.h>
#include <fresco/wording.h>

#include <algorithm>
#include <cstdint>
#include <fmt/format.h>
#include <map>
#include <memory>
#include <set>
#include <utility>
#include <vector>

using namespace fresco;
using namespace fresco::texturing;

namespace
{

/// A picture of a texture and where it is known.
struct KnownPicture
{
    RasterF rgb;       ///< S x S x 3
    Raster8 is_known;  ///< S x S
};

/// Rule for a region's texels: photo + strength (painted - photo).
struct RegionRule
{
    const KnownPicture* painted = nullptr;  ///< nullptr: the photo.
    float strength = 1;
};

constexpr std::uint32_t no_region = 0xffffffffU;

/// For each texel the region that it belongs to: that of its face, and beside a chart that of the chart's nearest texel, since
/// bilinear lookups at the chart's border reach it; no_region elsewhere.
std::vector<std::uint32_t> regions_of_texels(const TexelFaces& faces, const std::vector<std::uint16_t>& label_of_face)
{
    const int size = faces.size;
    // Neighbors at a side come before those at a corner.
    constexpr int around[8][2] = {{-1, 0}, {1, 0}, {0, -1}, {0, 1}, {-1, -1}, {1, -1}, {-1, 1}, {1, 1}};
    std::vector<std::uint32_t> result(faces.face.size(), no_region);
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x)
        {
            const auto number = [&](int i, int j)
            { return static_cast<std::size_t>(j) * static_cast<std::size_t>(size) + static_cast<std::size_t>(i); };
            const std::size_t texel = number(x, y);
            if (faces.covered(texel))
            {
                result[texel] = label_of_face[faces.face[texel]];
                continue;
            }
            for (const auto& [dx, dy] : around)
                if (x + dx >= 0 && x + dx < size && y + dy >= 0 && y + dy < size && faces.covered(number(x + dx, y + dy)))
                {
                    result[texel] = label_of_face[faces.face[number(x + dx, y + dy)]];
                    break;
                }
        }
    return result;
}

/// The photo with each region's texels by its rule. Where the strength is 0 or 1, texels are those of one picture, bit for bit; a
/// mixture is clamped to [0,1] and known where both pictures are. Texels without a region are the photo's, and not known. All
/// pictures have one size.
KnownPicture composed(const KnownPicture& photo, const std::vector<std::uint32_t>& region_of_texel,
                      const std::vector<RegionRule>& rules)
{
    KnownPicture result = photo;
    for (std::size_t texel = 0; texel < region_of_texel.size(); ++texel)
    {
        if (region_of_texel[texel] == no_region)
        {
            result.is_known.values[texel] = 0;
            continue;
        }
        const RegionRule& rule = rules[region_of_texel[texel]];
        if (rule.painted == nullptr || rule.strength == 0)
            continue;
        const bool whole = rule.strength == 1;
        result.is_known.values[texel] = whole || photo.is_known.values[texel] != 0 ? rule.painted->is_known.values[texel] : 0;
        for (std::size_t i = 3 * texel; i < 3 * texel + 3; ++i)
        {
            const float from = photo.rgb.values[i];
            const float to = rule.painted->rgb.values[i];
            result.rgb.values[i] = whole ? to : std::clamp(from + rule.strength * (to - from), 0.0F, 1.0F);
        }
    }
    return result;
}

/// The word for the stage's first texture, unchanged.
constexpr std::string_view kept_texture = "keep";

struct TextureRule
{
    std::string texture;  ///< An input, or kept_texture.
    double strength = 1;

    bool keeps() const { return texture == kept_texture; }
};

/// {floor: keep, walls: waves, "*": {texture: night, strength: 0.7}}. Each texture that a rule names becomes an input.
class TextureRules final : public Parameter
{
  public:
    /// `parts_of`: the input whose parts the rules are for.
    TextureRules(Configurable* owner, std::string name, std::string parts_of, std::string help)
        : Parameter(owner, {.name = std::move(name),
                            .kind = OptionKind::rules,
                            .required = true,
                            .rule = RuleForm{.parts_of = std::move(parts_of),
                                             .word = std::string(kept_texture),
                                             .input = "texture",
                                             .artifact = std::string(Texture::artifact_name),
                                             .version = Texture::artifact_version,
                                             .number = "strength"},
                            .help = std::move(help)}),
          owner_(owner)
    {
    }

    const std::map<std::string, TextureRule>& operator*() const { return rules_; }
    const std::map<std::string, std::unique_ptr<Input<Texture>>>& textures() const { return textures_; }

  private:
    void set(const Value& value, ComponentFactory&) override
    {
        rules_.clear();
        for (const auto& [part, rule] : value.as_map())
            rules_[part] = {rule.at("texture").as_string(), rule.at("strength").as_double()};
        for (const std::string& name : declaration().inputs_named(value))
            textures_[name] = std::make_unique<Input<Texture>>(owner_, name, "The texture '" + name + "' of the rules");
    }

    Configurable* owner_;
    std::map<std::string, TextureRule> rules_;
    std::map<std::string, std::unique_ptr<Input<Texture>>> textures_;
};

class TextureRegions final : public Stage
{
    Input<Texture> photo{this, "photo", "The photographic texture, for regions to keep and to mix with"};
    Input<Mesh> mesh{this, "mesh", "The mesh whose texcoords all textures were made for"};
    Input<Regions> regions{this, "regions", "The regions of that mesh"};
    Output<Texture> texture{this, "texture", "Each region from its texture"};
    TextureRules rules{this, "regions", "regions",
                       "For each region keep (the photo), a texture, or {texture: NAME, strength: 0.7}; '*': all other regions. "
                       "Each NAME is an input"};

    void check() const
    {
        check_has_atlas(*mesh, "the mesh on port 'mesh'", "the atlas.* stage that the textures were made with");
        check_regions(*regions, *mesh, "the regions on port 'regions'", "the mesh on port 'mesh'");
        check_input(*photo, "photo");
        for (const auto& [name, input] : rules.textures())
            check_input(**input, name);
        const std::vector<std::string> names = names_for_rules(regions->names);
        for (const auto& [name, rule] : *rules)
            if (name != other_parts && std::ranges::find(names, name) == names.end())
                throw Error("option \"regions\": there is no region '" + name + "'" + suggestion(name, names));
    }

    void check_input(const Texture& input, const std::string& port) const
    {
        check_texture(input);
        check_atlas(input.atlas, *mesh, "the texture on port '" + port + "'");
        if (input.size_px() != photo->size_px())
            throw Error(fmt::format("the texture on port 'photo' has {} texels a side, the one on port '{}' {}; make both with "
                                    "the same size_px",
                                    photo->size_px(), port, input.size_px()));
    }

    void run(RunContext& run) override
    {
        check();
        const Charts charts = find_charts(*mesh);
        const TexelFaces faces = find_texel_faces(*mesh, charts, photo->size_px(), run);
        // As texture.bake would fill them, so that what is next to a kept region cannot flow into it.
        const auto filled = [&](const Texture& source)
        {
            KnownPicture picture{collapse(source, run), source.seen};
            fill_unseen(*mesh, charts, faces, source.seen.values, picture.rgb, run);
            for (std::size_t texel = 0; texel < faces.face.size(); ++texel)
                if (faces.covered(texel))
                    picture.is_known.values[texel] = 1;
            return picture;
        };
        const double steps = static_cast<double>(rules.textures().size()) + 2;
        double done = 0;
        const KnownPicture from = filled(*photo);
        run.progress(++done, steps, "textures");
        std::map<std::string, KnownPicture> painted;
        for (const auto& [name, input] : rules.textures())
        {
            painted.emplace(name, filled(**input));
            run.progress(++done, steps, "textures");
        }
        const auto region_of_texel = regions_of_texels(faces, regions->label_of_face);
        KnownPicture picture = composed(from, region_of_texel, rules_by_label(painted));
        report(region_of_texel, from, picture, run);

        Texture result;
        result.atlas = atlas_id(*mesh);
        result.layers.push_back(std::move(picture.rgb));
        result.seen = std::move(picture.is_known);
        texture = std::move(result);
        run.progress(steps, steps, "textures");
    }

    /// The rule of a region and its name: the one for its path, else for the innermost name of it that has one, else for all
    /// others; nullptr where it has none and is kept.
    const std::pair<const std::string, TextureRule>* rule_of(const std::string& region) const
    {
        std::vector<std::string> names = names_in_path(region);
        names.insert(names.begin(), region);
        names.emplace_back(other_parts);
        for (const std::string& name : names)
            if (const auto found = (*rules).find(name); found != (*rules).end())
                return &*found;
        return nullptr;
    }

    std::vector<RegionRule> rules_by_label(const std::map<std::string, KnownPicture>& painted) const
    {
        std::vector<RegionRule> result(regions->names.size());
        for (std::size_t label = 0; label < result.size(); ++label)
            if (const auto* found = rule_of(regions->names[label]); found != nullptr && !found->second.keeps())
                result[label] = {&painted.at(found->second.texture), static_cast<float>(found->second.strength)};
        return result;
    }

    void report(const std::vector<std::uint32_t>& region_of_texel, const KnownPicture& from, const KnownPicture& to,
                RunContext& run) const
    {
        std::vector<std::size_t> texels(regions->names.size());
        std::vector<std::size_t> changed(texels.size());
        for (std::size_t texel = 0; texel < region_of_texel.size(); ++texel)
            if (const std::uint32_t label = region_of_texel[texel]; label != no_region)
            {
                const auto at = [&](const KnownPicture& picture)
                { return picture.rgb.values.begin() + static_cast<std::ptrdiff_t>(3 * texel); };
                ++texels[label];
                changed[label] += std::equal(at(from), at(from) + 3, at(to)) ? 0 : 1;
            }
        Value::Map figures;
        std::set<std::string> used{std::string(other_parts)};
        for (std::size_t label = 0; label < texels.size(); ++label)
        {
            const auto* found = rule_of(regions->names[label]);
            figures.emplace_back(regions->names[label],
                                 Value::Map{{"texture", found != nullptr ? found->second.texture : std::string(kept_texture)},
                                            {"texels", texels[label]},
                                            {"changed_texels", changed[label]}});
            if (texels[label] > 0 && found != nullptr)
                used.insert(found->first);
        }
        for (const auto& [name, rule] : *rules)
            if (!used.contains(name))
                run.warning("no part of the mesh is '" + name + "' without a closer rule: its rule changes nothing");
        run.report("regions", std::move(figures));
    }
};

}  // namespace

FRESCO_STAGE("texture.regions", TextureRegions, "Puts textures together by regions: some painted, some kept as photographed")
