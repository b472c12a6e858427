// Small stages for the tests of the host: tables with one number, and everything that can go wrong.
#include <fresco/component.h>
#include <fresco/file_access.h>
#include <fresco/files.h>
#include <fresco/files_io.h>
#include <fresco/mesh.h>
#include <fresco/reader.h>
#include <fresco/run_context.h>
#include <fresco/stage.h>

#include <chrono>
#include <fstream>
#include <iostream>
#include <limits>
#include <new>
#include <sstream>
#include <thread>
#include <utility>

namespace
{

/// A contract of the test plugin's own.
class Scaler : public fresco::Component
{
  public:
    static constexpr std::string_view component_kind = "scaler";
    static constexpr std::string_view default_type = "test.factor";
    virtual double scaled(double value) const = 0;
};

using fresco::Files;
using fresco::Input;
using fresco::Option;
using fresco::Output;
using fresco::RunContext;
using fresco::Table;

Table number(double value)
{
    Table table;
    table.columns = {"value"};
    table.rows = {{value}};
    return table;
}

double value_of(const Table& table)
{
    return table.rows.at(0).at(0).as_double();
}

Files listing(std::vector<std::string> names)
{
    Files files;
    files.names = std::move(names);
    return files;
}

/// One line per run, so that tests can count.
class LoggedStage : public fresco::Stage
{
  public:
    double memory_mb() const override { return 30; }

  protected:
    void log(const std::string& text)
    {
        if (!log_->empty())
            std::ofstream(*log_, std::ios::app) << text << '\n';
    }
    std::size_t logged(const std::string& beginning) const
    {
        std::ifstream file(*log_);
        std::size_t count = 0;
        for (std::string line; std::getline(file, line);)
            count += line.starts_with(beginning) ? 1 : 0;
        return count;
    }

  private:
    Option<std::string> log_{this, "log", "", "File that gets a line per run", fresco::not_in_key};
};

class Source final : public LoggedStage
{
    Output<Table> table{this, "table", "The number"};
    Option<double> value{this, "value", 1, "The number"};
    Option<fresco::InputFile> file{this, "file", fresco::InputFile{}, "Its size is added"};
    Option<fresco::InputFolder> folder{this, "folder", fresco::InputFolder{}, "The sizes of its files are added"};
    Option<std::string> beside{this, "beside", "", "The number in the file of this name beside `file` is added"};
    Option<int> wait_ms{this, "wait_ms", 0, fresco::range(0, 60'000), "Pause", fresco::not_in_key};

    void run(RunContext& run) override
    {
        log("source");
        double sum = *value;
        if (!file->empty())
            sum += static_cast<double>(std::filesystem::file_size(file->path));
        if (!beside->empty())
        {
            const std::filesystem::path other = file->path.parent_path() / *beside;
            run.reads_file(other);
            sum += std::stod(fresco::read_text_file(other));
        }
        if (!folder->empty())
        {
            run.reads_folder(folder->path, "*");
            for (const auto& entry : std::filesystem::directory_iterator(folder->path))
            {
                run.reads_file(entry.path());
                sum += static_cast<double>(fresco::read_file(entry.path()).size());
            }
        }
        std::this_thread::sleep_for(std::chrono::milliseconds(*wait_ms));
        run.report("threads", run.threads());
        run.message("made " + std::to_string(sum));
        table = number(sum);
    }
};
FRESCO_STAGE("test.source", Source, "A number from options and files")

class Add final : public LoggedStage
{
    Input<Table> left{this, "left", "First number"};
    Input<Table> right{this, "right", fresco::optional, "Second number"};
    Output<Table> sum{this, "sum", "Both together"};
    Option<double> plus{this, "plus", 0, "Added too"};
    Option<int> wait_ms{this, "wait_ms", 0, fresco::range(0, 60'000), "Pause", fresco::not_in_key};
    Option<int> together{
        this, "together", 1, fresco::range(1, 10), "Pause until a multiple of so many has begun", fresco::not_in_key};

    void run(RunContext&) override
    {
        log("add begins " + std::to_string(*plus));
        std::this_thread::sleep_for(std::chrono::milliseconds(*wait_ms));
        const auto size = static_cast<std::size_t>(*together);
        const std::size_t groups = (logged("add begins") + size - 1) / size;
        for (int i = 0; i < 6000 && logged("add begins") < groups * size; ++i)
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
        log("add ends " + std::to_string(*plus));
        sum = number(value_of(*left) + (right.has_value() ? value_of(*right) : 0) + *plus);
    }
};
FRESCO_STAGE("test.add", Add, "The sum of two numbers")

/// Reports figures that are no numbers, as a mean over nothing is.
class Maybe final : public LoggedStage
{
    Output<Table> table{this, "table", fresco::optional, "The number, if any"};
    Output<Table> always{this, "always", "Another number"};
    Option<bool> made{this, "made", true, "Whether there is one"};

    void run(RunContext& run) override
    {
        log("maybe");
        constexpr double none = std::numeric_limits<double>::quiet_NaN();
        constexpr double endless = std::numeric_limits<double>::infinity();
        run.metric("loss", none);
        run.progress(none, endless, "steps");
        std::this_thread::sleep_for(std::chrono::milliseconds(150));
        run.progress(1, 2, "steps");
        run.report("mean", none);
        run.report("ranges", fresco::Value::Map{{"list", fresco::Value::List{1.5, -endless}}, {"count", 3}});
        if (*made)
            table = number(7);
        always = number(1);
    }
};
FRESCO_STAGE("test.maybe", Maybe, "A number, or none")

/// Counts to `steps`, one checkpoint per step. Logs when it is stopped in order. A
/// checkpoint made with another number in the file would give another sum.
class Slow final : public LoggedStage
{
    Input<Table> start{this, "start", fresco::optional, "Where to begin"};
    Output<Table> counted{this, "counted", "The last number"};
    Option<int> steps{this, "steps", 20, fresco::range(1, 100'000), "How far"};
    Option<int> stop_at_step{this, "stop_at_step", 0, fresco::range(0, 100'000), "End early (0: not)"};
    Option<int> step_ms{this, "step_ms", 20, fresco::range(0, 10'000), "Pause per step", fresco::not_in_key};
    Option<std::string> file{this, "file", "", "File with the number that a step adds; empty: 1"};
    Option<int> fail_at{this, "fail_at", 0, fresco::range(0, 100'000), "Fail in this step (0: never)", fresco::not_in_key};

    void run(RunContext& run) override
    {
        const auto checkpoint = run.checkpoint_folder() / "step";
        int each = 1;
        if (!file->empty())
        {
            run.reads_file(*file);
            each = std::stoi(fresco::read_text_file(*file));
        }
        int step = 0;
        int sum = 0;
        if (fresco::path_status(checkpoint))
            try
            {
                std::istringstream(fresco::read_checked_text(checkpoint)) >> step >> sum;
            }
            catch (const fresco::Error& error)
            {
                run.warning(error.what());
            }
        log("slow from " + std::to_string(step));
        for (; step < (*stop_at_step > 0 ? *stop_at_step : *steps); ++step)
        {
            stop_if_told(run);
            if (step + 1 == *fail_at)
                throw fresco::Error("told to fail in step " + std::to_string(*fail_at));
            sum += each;
            run.metric("loss", 1.0 / (step + 1));
            run.progress(step, *steps, "steps");
            std::this_thread::sleep_for(std::chrono::milliseconds(*step_ms));
            fresco::write_checked(checkpoint, std::to_string(step + 1) + " " + std::to_string(sum));
        }
        counted = number((start.has_value() ? value_of(*start) : 0) + sum);
    }

    void stop_if_told(RunContext& run)
    {
        try
        {
            run.check_canceled();
        }
        catch (const fresco::Canceled&)
        {
            log("slow was stopped");
            throw;
        }
    }
};
FRESCO_STAGE("test.slow", Slow, "Counts slowly, with checkpoints")

class Fail final : public LoggedStage
{
    Input<Table> input{this, "input", fresco::optional, "Anything"};
    Output<Table> output{this, "output", "Never made"};
    Option<std::string> how{this, "how", "error",
                            fresco::one_of({"error", "missing", "exception", "memory", "nothing", "link", "full", "stubborn"}),
                            "What goes wrong"};

    void run(RunContext&) override
    {
        log("fail");
        std::cerr << "about to fail" << std::endl;
        if (*how == "error")
            throw fresco::Error("mesh.ply:7: three vertices expected, two found");
        if (*how == "missing")
            throw fresco::MissingInput("weights.safetensors: no such file");
        if (*how == "exception")
            throw std::out_of_range("index 7 of 3");
        if (*how == "memory")
            throw std::bad_alloc();
        if (*how == "full")
            throw fresco::Error("table.json: No space left on device");
        if (*how == "link")
            std::filesystem::create_symlink("/etc", output.folder().path / "link");
        while (*how == "stubborn")
            std::this_thread::sleep_for(std::chrono::milliseconds(50));
        if (*how != "nothing")
            output = number(0);
    }
};
FRESCO_STAGE("test.fail", Fail, "Fails in every way there is")

class Sink final : public LoggedStage
{
    Input<Table> table{this, "table", "What to write"};
    Output<Files> files{this, "files", "A text file"};
    Option<fresco::OutputName> path{this, "path", fresco::OutputName{"number.txt"}, "File below --out"};
    Option<int> copies{this, "copies", 0, fresco::range(0, 100'000), "More files, numbered"};
    Option<std::string> before{this, "before", "", "Text before the number"};
    Option<bool> origin{this, "origin", false, "Write where the number comes from instead, as JSON"};

    void run(RunContext& run) override
    {
        log("sink " + path->path);
        std::vector<std::string> names{path->path};
        for (int i = 0; i < *copies; ++i)
            names.push_back("copies/" + std::to_string(i) + ".txt");
        for (const std::string& name : names)
        {
            const auto file = files.folder().path / name;
            std::filesystem::create_directories(file.parent_path());
            fresco::write_file(file, *origin ? to_json(run.origin()) : *before + std::to_string(value_of(*table)) + "\n");
        }
        files = listing(std::move(names));
    }
};
FRESCO_STAGE("test.sink", Sink, "A number as a text file")

/// Files that outlive a killed run one by one.
class Pieces final : public LoggedStage
{
    Output<Files> files{this, "files", "Text files"};
    Option<int> count{this, "count", 5, fresco::range(1, 1000), "How many"};
    Option<int> wait_ms{this, "wait_ms", 0, fresco::range(0, 60'000), "Pause per file", fresco::not_in_key};

    void run(RunContext& run) override
    {
        const fresco::KeptPieces kept(run);
        std::vector<std::string> names;
        for (int i = 0; i < *count; ++i)
        {
            const auto piece = static_cast<std::size_t>(i);
            names.push_back("piece_" + std::to_string(i) + ".txt");
            if (kept.find(piece))
                continue;
            log("piece " + std::to_string(i));
            fresco::write_file(kept.folder() / names.back(), "piece " + std::to_string(i) + "\n");
            kept.note(piece, {names.back()}, {});
            std::this_thread::sleep_for(std::chrono::milliseconds(*wait_ms));
        }
        kept.link(names, files.folder().path);
        files = listing(std::move(names));
    }
};
FRESCO_STAGE("test.pieces", Pieces, "Text files, one at a time")

/// A mesh that its input already stores is linked. The option says how the stored one becomes damaged meanwhile.
class PassMesh final : public LoggedStage
{
    Input<fresco::Mesh> mesh{this, "mesh", fresco::optional, "Mesh to pass on"};
    Output<fresco::Mesh> passed{this, "passed", "The same, or a triangle"};
    Option<std::string> damage{this, "damage", "", "Damage the input unless this file exists, and make it", fresco::not_in_key};

    void run(RunContext&) override
    {
        log("pass");
        fresco::Mesh made;
        made.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
        made.triangles = {{0, 1, 2}};
        if (mesh.has_value())
            made.saved_in = mesh.folder();
        if (!damage->empty() && !std::filesystem::exists(*damage))
        {
            std::ofstream(*damage) << "done";
            std::ofstream(mesh.folder() / fresco::Mesh::file_name, std::ios::app) << "more";
        }
        passed = std::move(made);
    }
};
FRESCO_STAGE("test.pass_mesh", PassMesh, "A mesh without a copy")

class FactorScaler final : public Scaler
{
  public:
    double scaled(double value) const override { return value * *factor; }

  private:
    Option<double> factor{this, "factor", 2, "What to multiply by"};
};
FRESCO_COMPONENT("test.factor", FactorScaler, Scaler, "Multiplies")

class Scale final : public LoggedStage
{
    Input<Table> table{this, "table", "The number"};
    Output<Table> scaled{this, "scaled", "The number, scaled"};
    fresco::Slot<Scaler> first{this, "first", "test.factor", "First scaler"};
    fresco::Slot<Scaler> second{this, "Second scaler"};

    void run(RunContext& run) override
    {
        log("scale");
        run.report("shared", first.get() == second.get());
        scaled = number(second->scaled(first->scaled(value_of(*table))));
    }
};
FRESCO_STAGE("test.scale", Scale, "Scales by components")

class NumberReader final : public fresco::FileReader
{
  public:
    std::string artifact() const override { return "table"; }
    std::vector<std::string> extensions() const override { return {".number"}; }
    std::shared_ptr<const fresco::Artifact> read(const std::filesystem::path& file) override
    {
        return std::make_shared<Table>(number(std::stod(fresco::read_text_file(file))));
    }
};
FRESCO_COMPONENT("read.test_number", NumberReader, fresco::FileReader, "A number from a text file")

/// Files whose text is what they were made with.
class NoteOrigin final : public fresco::FileOrigin
{
  public:
    std::vector<std::string> extensions() const override { return {".note"}; }
    fresco::Value origin(const std::filesystem::path& file) const override
    {
        if (!std::filesystem::exists(file))
            throw fresco::MissingInput(file.string() + ": no such file");
        return fresco::parse_json(fresco::read_text_file(file), file.string());
    }
};
FRESCO_COMPONENT("origin.test_note", NoteOrigin, fresco::FileOrigin, "How a note was made")

FRESCO_LIBRARY("Testlib", "1.2.3")

}  // namespace
