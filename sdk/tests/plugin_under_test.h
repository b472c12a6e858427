#pragma once

#include <fresco/testing.h>

#include <map>
#include <memory>
#include <string>

/// \file Stages and components of the plugin that a test is built for.

namespace fresco::testing
{

/// A fixture for TEST_CASE_METHOD: a run and a folder.
struct StageTest
{
    TestRun run;
    TemporaryFolder folder;
};

/// Runs a stage and loads one of its outputs. Files that the output lies in are gone then: it must be an artifact that is loaded
/// as a whole.
template <class T>
std::shared_ptr<T> output_of(const char* type, const char* port, const Value& options, const Inputs& inputs, TestRun& run,
                             const std::map<std::string, std::shared_ptr<Component>>& components = {})
{
    const TemporaryFolder folder;
    run_stage(FRESCO_PLUGIN_FILE, type, options, inputs, folder.path(), run, components);
    return T::load({folder.path() / port, folder.path()});
}

/// A component with these options. Slots that it has are filled by `factory`.
template <class Contract>
std::unique_ptr<Contract> configured(const char* type, const Value& options, TestFactory&& factory = TestFactory())
{
    auto made = make_from_plugin<Contract>(FRESCO_PLUGIN_FILE, type);
    made->configure(options, factory);
    return made;
}

}  // namespace fresco::testing
