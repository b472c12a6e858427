#include "pair_figures.h"

#include "measure.h"

#include <limits>

using namespace fresco;

double least_detail(Protocol protocol)
{
    return protocol == Protocol::paper ? 0.5 / 255 : 0.5 * 0.5;
}

PairFigures judge_pair(const FramePair& pair, const JudgedView& source, const JudgedView& target, const Mesh& mesh,
                       const SurfacePaint* paint, const JudgeOptions& options, const Progress& progress)
{
    PairFigures figures;
    figures.pair = pair;
    const std::vector<Match> matches = covisible(source.surface, target.surface, options.protocol);
    figures.covisible = static_cast<double>(matches.size()) / static_cast<double>(source.surface.depth.values.size());
    figures.dropped = matches.empty() || figures.covisible < options.min_covisible;
    if (figures.dropped)
        return figures;

    std::unique_ptr<ProjectedPaint> projected;
    if (paint == nullptr)
        projected = std::make_unique<ProjectedPaint>(mesh, source.surface.camera, source.picture);
    const FloorPictures low_passed =
        floor_pictures(source.surface, target.surface, matches, paint != nullptr ? *paint : *projected, progress);

    figures.value = reprojection_difference(source.picture, target.picture, matches, options.protocol);
    figures.floor = reprojection_difference(low_passed.source, low_passed.target, matches, options.protocol);
    figures.detail = forward_difference(source.picture, matches, options.protocol);
    figures.sharpness = sharpness(source.picture, matches);
    figures.flat = figures.detail < least_detail(options.protocol);
    figures.headline = figures.flat ? std::numeric_limits<double>::quiet_NaN() : (figures.value - figures.floor) / figures.detail;
    return figures;
}

GapFigures summary(const std::vector<PairFigures>& pairs, const evaluation::Bootstrap& bootstrap)
{
    GapFigures result;
    for (const PairFigures& pair : pairs)
    {
        result.dropped += pair.dropped ? 1 : 0;
        result.kept += pair.dropped ? 0 : 1;
        result.flat += !pair.dropped && pair.flat ? 1 : 0;
    }
    result.invalid = result.kept == 0 || result.flat * 2 >= result.kept;
    const auto figure = [&](double PairFigures::*member, bool flat_too)
    {
        std::vector<double> values;
        for (const PairFigures& pair : pairs)
            if (!pair.dropped && (flat_too || !pair.flat))
                values.push_back(pair.*member);
        return Figure{evaluation::mean(values), evaluation::bootstrap_mean(values, bootstrap)};
    };
    result.value = figure(&PairFigures::value, true);
    result.floor = figure(&PairFigures::floor, true);
    result.sharpness = figure(&PairFigures::sharpness, true);
    result.detail = figure(&PairFigures::detail, true);
    result.headline = figure(&PairFigures::headline, false);
    return result;
}
