#pragma once

#include <fresco/component.h>
#include <fresco/error.h>
#include <fresco/run_context.h>
#include <fresco/stage.h>

#include <atomic>
#include <concepts>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

/// \file For the tests of plugins: run a stage without the host.

namespace fresco::testing
{

/// A folder that is removed with the object.
class TemporaryFolder
{
  public:
    TemporaryFolder();
    ~TemporaryFolder();
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;
    const std::filesystem::path& path() const { return path_; }

  private:
    std::filesystem::path path_;
};

/// A RunContext that keeps what a stage says. cancel_after(n): the n-th check_canceled throws.
class TestRun final : public RunContext
{
  public:
    explicit TestRun(int threads = 2);
    ~TestRun() override;

    std::vector<std::string> messages;  ///< Warnings begin with "warning: ".
    Value reported{Value::Map{}};
    Value origin_given{Value::Map{}};  ///< Result of origin().
    std::map<std::string, std::vector<double>> metrics;
    std::vector<std::filesystem::path> files_read;
    std::vector<std::filesystem::path> folders_read;  ///< Folder / pattern of names.

    void cancel_after(int checks) { checks_left_ = checks; }

    void progress(double done, double total, std::string_view unit) override;
    void check_canceled() const override;
    int threads() const override { return threads_; }
    void message(std::string_view text) override;
    void warning(std::string_view text) override;
    void metric(std::string_view name, double value) override;
    void report(std::string_view key, Value value) override;
    Value origin() const override { return origin_given; }
    std::filesystem::path preview_folder() override;
    std::filesystem::path scratch_folder() override;
    std::filesystem::path checkpoint_folder() override;
    void reads_file(const std::filesystem::path& file) override;
    using RunContext::reads_folder;
    void reads_folder(const std::filesystem::path& folder, std::string_view names) override;

  private:
    TemporaryFolder folder_;
    int threads_;
    mutable std::atomic<int> checks_left_{-1};
};

/// Makes components from functions registered by type; for slots in stages under test.
class TestFactory final : public ComponentFactory
{
  public:
    ~TestFactory() override;
    void add(const std::string& type, std::function<std::shared_ptr<Component>()> make);
    std::shared_ptr<Component> create(std::string_view kind, const Value& config) override;

  private:
    std::map<std::string, std::function<std::shared_ptr<Component>()>> makers_;
    std::map<std::string, std::shared_ptr<Component>> made_;
};

/// The text of the Error that `work` throws; "" if it throws none.
template <std::invocable Work>
std::string error_of(const Work& work)
{
    try
    {
        work();
    }
    catch (const Error& error)
    {
        return error.what();
    }
    return "";
}

/// Inputs of a stage, by its ports.
using Inputs = std::map<std::string, std::shared_ptr<const Artifact>>;

/// Configures, wires and runs a stage; outputs are saved below `folder` (one folder per output) and can be loaded from there.
void run_stage(Stage& stage, const Value& options, const Inputs& inputs, const std::filesystem::path& folder, TestRun& run,
               ComponentFactory& factory);
/// Runs a stage of a built plugin; `components`: components for its slots of these names, if it has them.
void run_stage(const std::filesystem::path& library, std::string_view type, Value options, const Inputs& inputs,
               const std::filesystem::path& folder, TestRun& run,
               const std::map<std::string, std::shared_ptr<Component>>& components = {});

/// Opens a built plugin in this process after the handshake and makes one object of a type it holds; the test owns it. The
/// library stays open. Throws Error naming the file.
std::unique_ptr<Configurable> make_from_plugin(const std::filesystem::path& library, std::string_view type);
/// Makes a type as a Loss, an OptimizerRule, a Stage … Throws Error if the type is something else.
template <class Contract>
std::unique_ptr<Contract> make_from_plugin(const std::filesystem::path& library, std::string_view type)
{
    auto made = make_from_plugin(library, type);
    auto* contract = dynamic_cast<Contract*>(made.get());
    if (contract == nullptr)
        throw Error(library.string() + ": '" + std::string(type) + "' is of another kind than its test expects");
    (void)made.release();
    return std::unique_ptr<Contract>(contract);
}

}  // namespace fresco::testing
