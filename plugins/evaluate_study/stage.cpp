#include "page.h"
#include "results.h"

#include <fresco/evaluation/statistics.h>
#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/frames.h>
#include <fresco/stage.h>

#include <algorithm>
#include <fmt/format.h>

using namespace fresco;
using namespace study;

namespace
{
constexpr const char* default_questions =
    "Which picture has less visible stretch? | In which picture are patterns in the background smaller?";
constexpr std::size_t large_page = std::size_t{64} << 20U;

class EvaluateStudy final : public Stage
{
    Input<Files> first{this, "first", optional, "Pictures of one method, as render.views makes them"};
    Input<Files> second{this, "second", optional, "Pictures of another method"};
    Output<Files> files{this, "files", "The page, its key, and the figures if there are results"};
    Option<std::string> first_name{this, "first_name", "first", "Name of the method on port 'first' in the figures"};
    Option<std::string> second_name{this, "second_name", "second", "The same for port 'second'"};
    Option<InputFolder> folder{this, "folder", InputFolder{}, "Folder with a subfolder of pictures per method, named after it"};
    Option<std::string> questions{this, "questions", default_questions, "Questions about each pair, separated by |"};
    Option<std::string> ours{this, "ours", "",
                             "Compare only this method with the others, as the paper did; empty: all pairs of methods"};
    Option<std::string> question_order{this, "question_order", "grouped", one_of({"grouped", "mixed"}),
                                       "One question after the other, or in random order"};
    Option<InputFile> hints{this, "hints", InputFile{}, formats({json_format()}),
                            "Rectangles to draw into pictures: see the README"};
    Option<int> pairs_count{this, "pairs_count", 70, range(1, 10'000),
                            "Number of pairs shown to each participant, each with one question"};
    Option<int> pictures_count{this, "pictures_count", 40, range(1, 10'000),
                               "Number of views per method in the page, evenly spread"};
    Option<int> max_px{this, "max_px", 960, range(64, 8192), "Maximum longer side of the pictures in the page"};
    Option<std::string> image_format{this, "image_format", "jpeg", one_of({"jpeg", "png"}),
                                     "How pictures are stored in the page"};
    Option<int> jpeg_quality{this, "jpeg_quality", 90, range(1, 100), "For image_format: jpeg"};
    evaluation::BootstrapOptions bootstrap{this, "Seed of the pictures' numbers and of the resampling"};
    Option<InputFolder> results{this, "results", InputFolder{}, folder_with({"*.json"}), "Folder of the participants' results"};
    Option<InputFile> key{this, "key", InputFile{}, formats({json_format()}),
                          "Key of the earlier study that the results come from; replaces its pictures"};
    Option<OutputName> path{this, "path", OutputName{"study.html"}, extensions({".html"}), "Name of the page, below --out"};
    Slot<ImageIo> images{this, "Reads and encodes the pictures"};

    std::string sibling(const char* extension) const
    {
        return std::filesystem::path(path->path).replace_extension(extension).generic_string();
    }

    std::vector<MethodPictures> methods(RunContext& run) const
    {
        std::vector<MethodPictures> result;
        if (!folder->empty())
            result = pictures_below(folder->path, run);
        if (first.has_value())
            result.push_back(pictures_of(*first_name, *first));
        if (second.has_value())
            result.push_back(pictures_of(*second_name, *second));
        return result;
    }

    /// The study of the pictures; its page and key are written.
    Study written_study(Files& result, RunContext& run) const
    {
        const auto all = methods(run);
        const auto groups = compared_groups(all, static_cast<std::size_t>(*pictures_count));
        for (const Group& group : groups)
            for (const auto& [method, file] : group.files)
                run.reads_file(file);
        const ShownAs shown{.max_px = *max_px, .png = *image_format == "png", .jpeg_quality = *jpeg_quality};
        Design design{*ours, *question_order == "mixed", {}};
        if (!hints->empty())
            design.hints = hints_from(read_text_file(hints->path), hints->path.string());
        const Study study = make_study(groups, split_questions(*questions), *pairs_count, std::move(design), bootstrap.seed(),
                                       fmt::format("{}{}{}", *max_px, *image_format, *jpeg_quality));
        const std::string text = page(study, encoded_pictures(study, groups, shown, *images, run));
        write(path->path, text, result);
        write(sibling(".key.json"), key_text(study), result);

        run.report("study", study.id);
        run.report("pictures", study.pictures.size());
        run.report("page_bytes", text.size());
        std::size_t pairs = 0;
        for (const Comparison& comparison : comparisons(study))
            pairs += comparison.pairs.size();
        run.report("pairs", pairs);
        if (pairs * study.questions.size() < static_cast<std::size_t>(*pairs_count))
            run.warning(
                fmt::format("only {} pairs for {} questions: each participant sees every pair once, fewer than pairs_count",
                            pairs, study.questions.size()));
        if (text.size() > large_page)
            run.warning(
                fmt::format("the page has {} MB: for phones, lower pictures_count, max_px or jpeg_quality", text.size() >> 20U));
        return study;
    }

    Study study_of_key(RunContext& run) const
    {
        if (results->empty())
            throw Error("option \"key\" is set without results: set option \"results\" to the folder of result files too");
        if (first.has_value() || second.has_value() || !folder->empty())
            throw Error("both the key of a study and its pictures are set: set only one of them");
        Study study = key_from(read_text_file(key->path), key->path.string());
        run.report("study", study.id);
        return study;
    }

    std::vector<AnswerSheet> sheets(const Study& study, RunContext& run) const
    {
        run.reads_folder(results->path, "*.json");
        std::vector<std::filesystem::path> found;
        for (const auto& entry : std::filesystem::directory_iterator(results->path))
            if (entry.is_regular_file() && entry.path().extension() == ".json")
                found.push_back(entry.path());
        std::ranges::sort(found);
        if (found.empty())
            throw MissingInput(results->path.string() + ": no result files (*.json)");
        for (const auto& file : found)
            run.reads_file(file);
        return read_sheets(found, study);
    }

    void tell(const Study& study, const std::vector<AnswerSheet>& sheets, Files& result, RunContext& run) const
    {
        const auto found = verdicts(study, sheets, *bootstrap);
        const auto complete = static_cast<std::size_t>(std::ranges::count(sheets, true, &AnswerSheet::complete));
        if (complete < sheets.size())
            run.warning(fmt::format("{} of {} participants finished early; their answers count", sheets.size() - complete,
                                    sheets.size()));
        for (const Verdict& verdict : found)
            run.message(verdict_line(study, verdict));
        const Value figures = results_value(study, sheets, found);
        for (const auto& [name, value] : figures.as_map())
            run.report(name, value);
        write(sibling(".results.json"), to_json(figures, 1) + "\n", result);
    }

    void write(const std::string& name, const std::string& text, Files& result) const
    {
        const auto file = files.folder().path / name;
        std::filesystem::create_directories(file.parent_path());
        write_file(file, text);
        result.names.push_back(name);
    }

    void run(RunContext& run) override
    {
        Files result;
        const Study study = key->empty() ? written_study(result, run) : study_of_key(run);
        if (!results->empty())
            tell(study, sheets(study, run), result, run);
        files = std::move(result);
    }
};
}  // namespace

FRESCO_STAGE("evaluate.study", EvaluateStudy, "User study: a page of picture pairs, and how often each method was chosen")
