// Stages that write as the ready ones do: checked files that resume, and exports.
#include <fresco/checked_file.h>
#include <fresco/error.h>
#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/stage.h>

#include <filesystem>
#include <string>

namespace
{

using fresco::Files;
using fresco::Input;
using fresco::Option;
using fresco::Output;
using fresco::RunContext;
using fresco::Table;

/// Adds a file's number to the start, once per step. A checkpoint of another number in the file would give another sum.
class Count final : public fresco::Stage
{
    Input<Table> start{this, "start", "Where to begin"};
    Output<Table> counted{this, "counted", "The sum"};
    Option<std::string> file{this, "file", fresco::required, "File with the number to add"};
    Option<int> steps{this, "steps", 4, fresco::range(1, 1000), "How often"};
    Option<int> fail_at{this, "fail_at", 0, fresco::range(0, 1000), "Fail before this step (0: never)", fresco::not_in_key};

    void run(RunContext& run) override
    {
        run.reads_file(*file);
        const int number = std::stoi(fresco::read_text_file(*file));
        const std::filesystem::path checkpoint = run.checkpoint_folder() / "state";
        int step = 0;
        double sum = start->rows.at(0).at(0).as_double();
        if (std::filesystem::exists(checkpoint))
            try
            {
                const fresco::Value state = fresco::parse_json(fresco::read_checked_text(checkpoint), checkpoint.string());
                step = static_cast<int>(state.at("step").as_int());
                sum = state.at("sum").as_double();
            }
            catch (const fresco::Error& error)
            {
                run.warning(error.what());
            }
        while (step < *steps)
        {
            ++step;
            if (step == *fail_at)
                throw fresco::Error("told to fail at step " + std::to_string(step));
            sum += number;
            run.metric("sum", sum);
            run.progress(step, *steps, "steps");
            fresco::write_checked(checkpoint, fresco::to_json(fresco::Value::Map{{"step", step}, {"sum", sum}}));
        }
        Table table;
        table.columns = {"value"};
        table.rows = {{sum}};
        counted = std::move(table);
    }
};
FRESCO_STAGE("prove.count", Count, "Counts, with checkpoints")

class Write final : public fresco::Stage
{
    Input<Table> table{this, "table", "What to write"};
    Output<Files> files{this, "files", "Text files"};
    Option<std::string> before{this, "before", "value", "Text before the number"};

    void run(RunContext&) override
    {
        Files made;
        for (const std::string name : {"value.txt", "below/value.txt"})
        {
            const auto path = files.folder().path / name;
            std::filesystem::create_directories(path.parent_path());
            fresco::write_file(path, *before + " " + std::to_string(table->rows.at(0).at(0).as_double()) + "\n");
            made.names.push_back(name);
        }
        files = std::move(made);
    }
};
FRESCO_STAGE("prove.write", Write, "A number as text files")

}  // namespace
