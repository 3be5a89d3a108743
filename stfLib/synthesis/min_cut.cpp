// SPDX-License-Identifier: Apache-2.0
#include "stfLib/synthesis/min_cut.h"

// Boost's iterators over the edges of a graph without any look unset to the compiler.
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif
#include <boost/graph/boykov_kolmogorov_max_flow.hpp>
#include <boost/graph/compressed_sparse_row_graph.hpp>
#include <cstdint>
#include <vector>

namespace stf {

namespace {

/// Arcs in one array, sorted by their source: an adjacency list would allocate each of them.
using Graph = boost::compressed_sparse_row_graph<boost::directedS, boost::no_property, boost::no_property,
                                                 boost::no_property, std::uint32_t, std::uint32_t>;
using Edge = boost::graph_traits<Graph>::edge_descriptor;

} // namespace

struct MinCut::Impl {
    explicit Impl(std::size_t nodes) : source(nodes), sink(nodes + 1), terminal(nodes, 0.0f) {}

    /// An arc and its reverse; the reverse carries nothing at first.
    struct Pair {
        std::uint32_t from, to;
        float capacity;
    };

    std::size_t source, sink;
    std::vector<float> terminal;
    std::vector<Pair> pairs;
    std::vector<boost::default_color_type> colour; ///< of the search trees, per node
};

MinCut::MinCut(std::size_t nodes) : impl_(std::make_unique<Impl>(nodes)) {}
MinCut::~MinCut() = default;

void MinCut::addTerminal(std::size_t node, float cost) {
    impl_->terminal[node] += cost;
}

void MinCut::addPair(std::size_t a, std::size_t b, float cost) {
    if (cost > 0) {
        impl_->pairs.push_back({std::uint32_t(a), std::uint32_t(b), cost});
    }
}

void MinCut::solve() {
    Impl& m = *impl_;
    for (std::size_t n = 0; n < m.terminal.size(); ++n) {
        const float cost = m.terminal[n];
        if (cost > 0) {
            m.pairs.push_back({std::uint32_t(m.source), std::uint32_t(n), cost});
        } else if (cost < 0) {
            m.pairs.push_back({std::uint32_t(n), std::uint32_t(m.sink), -cost});
        }
    }
    // Where the arcs of each node start.
    const std::size_t nodes = m.terminal.size() + 2, arcs = 2 * m.pairs.size();
    std::vector<std::uint32_t> next(nodes + 1, 0);
    for (const Impl::Pair& p : m.pairs) {
        ++next[p.from + 1];
        ++next[p.to + 1];
    }
    for (std::size_t n = 0; n < nodes; ++n) {
        next[n + 1] += next[n];
    }
    std::vector<std::pair<std::uint32_t, std::uint32_t>> ends(arcs);
    std::vector<float> capacity(arcs, 0.0f), residual(arcs);
    std::vector<Edge> reverse(arcs);
    for (const Impl::Pair& p : m.pairs) {
        const std::uint32_t there = next[p.from]++, back = next[p.to]++;
        ends[there] = {p.from, p.to};
        ends[back] = {p.to, p.from};
        capacity[there] = p.capacity;
        reverse[there] = Edge(p.to, back);
        reverse[back] = Edge(p.from, there);
    }
    const Graph graph(boost::edges_are_sorted, ends.begin(), ends.end(), std::uint32_t(nodes));
    ends = {};
    m.colour.assign(nodes, boost::default_color_type());
    std::vector<Edge> predecessor(nodes);
    std::vector<long> distance(nodes);
    const auto edgeIndex = boost::get(boost::edge_index, graph);
    const auto vertexIndex = boost::get(boost::vertex_index, graph);
    const auto map = [](auto& values, const auto& index) {
        return boost::make_iterator_property_map(values.begin(), index);
    };
    boost::boykov_kolmogorov_max_flow(graph, map(capacity, edgeIndex), map(residual, edgeIndex),
                                      map(reverse, edgeIndex), map(predecessor, vertexIndex),
                                      map(m.colour, vertexIndex), map(distance, vertexIndex), vertexIndex,
                                      std::uint32_t(m.source), std::uint32_t(m.sink));
}

bool MinCut::onSink(std::size_t node) const {
    return impl_->colour[node] == impl_->colour[impl_->sink];
}

} // namespace stf
