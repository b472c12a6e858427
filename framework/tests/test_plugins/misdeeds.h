#pragma once

#include <filesystem>
#include <string>

/// Leaves a process that never ends; in a session of its own it is the grandchild of a process that has ended, as services start.
void leave_process(bool in_session);

/// What is done to the machine, the store and other stages. `output`: the folder of the stage's output, in the store. Returns
/// where the way allows it.
void do_misdeed(const std::string& how, const std::filesystem::path& output);

/// In a constructor, by the environment variable MISBEHAVE_AT_START.
void misbehave_at_start();
