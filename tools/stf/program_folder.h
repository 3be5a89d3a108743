// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

namespace stf {

/// The folder of the running program; empty where the system does not say.
std::filesystem::path programFolder();

/// The path of a program beside this one, or else its bare name, to be looked for on the path.
std::string programBeside(const std::string& name);

} // namespace stf
