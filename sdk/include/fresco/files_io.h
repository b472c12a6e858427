#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// Whole files, read and written. Every write replaces the file in one step or leaves the old one: it goes to a nameless file in
/// the same folder (under a random name if the file system has no such files), which is then renamed. Of several writers of one
/// file one is last. Which writer:
///   write_file          what a stage makes: the host flushes it to the disk once, before it publishes the result
///   write_durable_file  everything else: on the disk when it returns
///   write_checked       checkpoints: durable, with a checksum that read_checked compares
///   copy_files          many durable copies with one flush
/// All throw Error naming the file and the cause, such as a full disk, and leave nothing behind. Below a folder in which links
/// are forbidden (file_access.h), a link in place of a folder is an error, and one in place of the file is replaced.

namespace fresco
{

/// The whole file. Throws MissingInput if it cannot be opened, Error if it is not a regular file or larger than `limit_bytes`.
std::vector<std::byte> read_file(const std::filesystem::path& file, std::size_t limit_bytes = std::size_t{1} << 33U);
std::string read_text_file(const std::filesystem::path& file, std::size_t limit_bytes = std::size_t{1} << 26U);

/// How the names of files begin that are on their way to another name, as long as they have one. The rest is 32 hexadecimal
/// digits.
inline constexpr std::string_view temporary_file_prefix = ".fresco-";

void write_file(const std::filesystem::path& file, std::span<const std::byte> bytes);
void write_file(const std::filesystem::path& file, std::string_view text);

void write_durable_file(const std::filesystem::path& file, std::span<const std::byte> bytes);
void write_durable_file(const std::filesystem::path& file, std::string_view text);
/// Writes pieces one after the other: large data need not be joined in memory first.
void write_durable_file(const std::filesystem::path& file, std::span<const std::span<const std::byte>> pieces);

void write_checked(const std::filesystem::path& file, std::span<const std::byte> bytes);
void write_checked(const std::filesystem::path& file, std::string_view text);
/// The bytes that write_checked wrote. Throws MissingInput if there is no such file, Error naming it if it is damaged.
std::vector<std::byte> read_checked(const std::filesystem::path& file);
std::string read_checked_text(const std::filesystem::path& file);

struct FileCopy
{
    std::filesystem::path from;
    std::filesystem::path to;
};
/// Copies files so that none appears under its name before the data of all are on the disk; `written` is called then. Opens a
/// descriptor per file. Throws what `written` throws, too.
void copy_files(std::span<const FileCopy> copies, const std::function<void()>& written = {});

/// 128-bit content hash (XXH3) as 32 hexadecimal digits. Not cryptographic: it finds change and damage, not an attacker.
std::string content_hash(std::span<const std::byte> bytes);
std::string content_hash(std::string_view text);
/// Hash of a file's bytes, streamed. Throws MissingInput if it cannot be read.
std::string file_hash(const std::filesystem::path& file);

}  // namespace fresco
