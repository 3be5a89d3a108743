// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <memory>

namespace stf {

/// The cheapest division of nodes into two sides, source and sink: max-flow after Boykov & Kolmogorov 2004, "An
/// experimental comparison of min-cut/max-flow algorithms for energy minimization in vision", by Boost.Graph.
class MinCut {
public:
    explicit MinCut(std::size_t nodes);
    ~MinCut();
    MinCut(const MinCut&) = delete;
    MinCut& operator=(const MinCut&) = delete;

    /// Adds to the cost of a node for being on the sink's side; negative: for being on the source's.
    void addTerminal(std::size_t node, float cost);
    /// Costs `cost` (not negative) where `a` is on the source's side and `b` on the sink's.
    void addPair(std::size_t a, std::size_t b, float cost);

    void solve();
    /// After `solve`. Nodes that may be on either side are on the source's.
    bool onSink(std::size_t node) const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace stf
