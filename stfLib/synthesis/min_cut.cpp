// SPDX-License-Identifier: Apache-2.0
#include "stfLib/synthesis/min_cut.h"

// Boost's iterators over the edges of a graph without any look unset to the compiler.
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif
#include <boost/graph/adjacency_list.hpp>
#include <boost/graph/boykov_kolmogorov_max_flow.hpp>
#include <vector>

namespace stf {

namespace {

using Traits = boost::adjacency_list_traits<boost::vecS, boost::vecS, boost::directedS>;
using VertexProperties =
    boost::property<boost::vertex_color_t, boost::default_color_type,
                    boost::property<boost::vertex_distance_t, long,
                                    boost::property<boost::vertex_predecessor_t, Traits::edge_descriptor>>>;
using EdgeProperties =
    boost::property<boost::edge_capacity_t, float,
                    boost::property<boost::edge_residual_capacity_t, float,
                                    boost::property<boost::edge_reverse_t, Traits::edge_descriptor>>>;
using Graph = boost::adjacency_list<boost::vecS, boost::vecS, boost::directedS, VertexProperties, EdgeProperties>;

} // namespace

struct MinCut::Impl {
    explicit Impl(std::size_t nodes) : graph(nodes + 2), source(nodes), sink(nodes + 1), terminal(nodes, 0.0f) {}

    void connect(std::size_t a, std::size_t b, float capacity) {
        const Traits::edge_descriptor e = boost::add_edge(a, b, graph).first, r = boost::add_edge(b, a, graph).first;
        boost::put(boost::edge_capacity, graph, e, capacity);
        boost::put(boost::edge_capacity, graph, r, 0.0f);
        boost::put(boost::edge_reverse, graph, e, r);
        boost::put(boost::edge_reverse, graph, r, e);
    }

    Graph graph;
    std::size_t source, sink;
    std::vector<float> terminal;
};

MinCut::MinCut(std::size_t nodes) : impl_(std::make_unique<Impl>(nodes)) {}
MinCut::~MinCut() = default;

void MinCut::addTerminal(std::size_t node, float cost) {
    impl_->terminal[node] += cost;
}

void MinCut::addPair(std::size_t a, std::size_t b, float cost) {
    if (cost > 0) {
        impl_->connect(a, b, cost);
    }
}

void MinCut::solve() {
    for (std::size_t n = 0; n < impl_->terminal.size(); ++n) {
        const float cost = impl_->terminal[n];
        if (cost > 0) {
            impl_->connect(impl_->source, n, cost);
        } else if (cost < 0) {
            impl_->connect(n, impl_->sink, -cost);
        }
    }
    boost::boykov_kolmogorov_max_flow(impl_->graph, impl_->source, impl_->sink);
}

bool MinCut::onSink(std::size_t node) const {
    return boost::get(boost::vertex_color, impl_->graph, node) ==
           boost::get(boost::vertex_color, impl_->graph, impl_->sink);
}

} // namespace stf
