// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "stfLib/base/temporary_folder.h"

#include <fstream>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <string>

namespace stf::test {

using stf::TemporaryFolder;

/// Numbers computed by another method, tests/data/reference/<name>; what they are is in their "about".
inline nlohmann::json reference(const std::string& name) {
    std::ifstream in(std::string(STF_TEST_DATA) + "/reference/" + name);
    return nlohmann::json::parse(in);
}

/// The text of the exception of type E that f throws; empty, with a failure, where it throws none.
template<class E, class F>
std::string messageOf(F f) {
    try {
        f();
    } catch (const E& e) {
        return e.what();
    }
    ADD_FAILURE() << "nothing was thrown";
    return {};
}

} // namespace stf::test
