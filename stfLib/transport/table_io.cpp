// SPDX-License-Identifier: Apache-2.0
#include "stfLib/base/parallel.h"
#include "stfLib/transport/indexed_vdb.h"
#include "stfLib/transport/stf_table.h"
#include "stfLib/volume/base_volume.h"
#include "stfLib/volume/vdb_dense.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <exception>
#include <openvdb/math/Half.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

// Version 2. A part `multiple` of rank n is the grids multiple_000 to multiple_<n-1> (Vec3f, rgb fluence of a_k) and,
// with flux, multiple_000_flux_x and so on; over voxels in half precision, each scaled by a power of two (its metadata
// stf:exponent) to where half has its widest range; over columns in float. multiple_basis (float, x = k, y = direction)
// holds b_k. stf:multiple in the file's metadata is (rank, components, directions). Parts that are empty are absent.
// Everything small is read at once, the factors of a part when it is first used.

namespace stf {

namespace {

constexpr int kTableVersion = 3;
constexpr int kLargestExponent = 13; ///< of a scaled factor: its largest value lies in [2^12, 2^13)
constexpr int kMostDirections = 1 << 16;
constexpr const char* kGroups[4] = {"", "_flux_x", "_flux_y", "_flux_z"};

struct Part {
    const char* name;
    Lazy<FactoredField> StfTable::*field;
    bool columns, allDirections;
};
constexpr std::array<Part, 6> kParts{{{"multiple", &StfTable::multiple, false, true},
                                      {"single", &StfTable::single, false, true},
                                      {"backlight", &StfTable::backlight, false, false},
                                      {"emitted", &StfTable::emitted, false, false},
                                      {"transmitted", &StfTable::transmitted, true, true},
                                      {"direct", &StfTable::direct, true, true}}};

struct NumberMeta {
    const char* key;
    double TableError::*value;
};
constexpr std::array<NumberMeta, 6> kErrors{{{"stf:error_target", &TableError::target},
                                             {"stf:error_noise", &TableError::noise},
                                             {"stf:error_directions", &TableError::directions},
                                             {"stf:error_truncation", &TableError::truncation},
                                             {"stf:error_filter", &TableError::filter},
                                             {"stf:error_storage", &TableError::storage}}};

Vec3i sizeOf(const Part& part, const Vec3i& size) {
    return part.columns ? Vec3i(size.x, size.y, 1) : size;
}

std::size_t product(const Vec3i& size) {
    return std::size_t(size.x) * std::size_t(size.y) * std::size_t(size.z);
}

std::string gridName(const char* part, int k, int group) {
    char text[64];
    std::snprintf(text, sizeof text, "%s_%03d%s", part, k, kGroups[group]);
    return text;
}

bool allFinite(const std::vector<float>& values) {
    return std::all_of(values.begin(), values.end(), [](float v) { return std::isfinite(v); });
}
bool allFinite(const std::vector<Rgb>& values) {
    return std::all_of(values.begin(), values.end(), [](const Rgb& v) { return isFinite(v); });
}

// Calls f by itself: OpenVDB's parallel loops in it take up no tasks of others (who may wait for what f makes, see
// Lazy), and they do not end early, without a word, where a loop around f was cancelled.
void alone(const std::function<void()>& f) {
    tbb::task_group_context context(tbb::task_group_context::isolated);
    std::exception_ptr error;
    const auto body = [&](int) {
        try {
            f();
        } catch (...) {
            error = std::current_exception();
        }
    };
    tbb::this_task_arena::isolate([&] { tbb::parallel_for(0, 1, body, context); });
    if (error) {
        std::rethrow_exception(error);
    }
}

// ---- writing

// The power of two that brings the largest value to where half precision is used best.
int exponentOf(const std::vector<Rgb>& values) {
    float largest = 0;
    for (const Rgb& v : values) {
        largest = std::max({largest, std::abs(v.x), std::abs(v.y), std::abs(v.z)});
    }
    int exponent = 0;
    std::frexp(largest, &exponent);
    return largest > 0 ? exponent - kLargestExponent : 0;
}

std::vector<Rgb> group(const FactoredField& f, int k, int g) {
    const std::size_t width = std::size_t(f.components), stride = width * std::size_t(f.rank);
    std::vector<Rgb> values(f.items());
    const float* p = f.factors.data() + std::size_t(k) * width + std::size_t(g) * 3;
    for (std::size_t i = 0; i < values.size(); ++i, p += stride) {
        values[i] = {p[0], p[1], p[2]};
    }
    return values;
}

void scaleBy(std::vector<Rgb>& values, int exponent) {
    const double scale = std::ldexp(1.0, exponent);
    for (Rgb& v : values) {
        v = {float(double(v.x) * scale), float(double(v.y) * scale), float(double(v.z) * scale)};
    }
}

openvdb::GridBase::Ptr factorGrid(const Part& part, const FactoredField& f, int k, int g, const StfTable& t) {
    std::vector<Rgb> values = group(f, k, g);
    const int exponent = part.columns ? 0 : exponentOf(values);
    scaleBy(values, -exponent);
    openvdb::GridBase::Ptr grid = toGrid(values, sizeOf(part, t.size), t.voxelMm, gridName(part.name, k, g));
    grid->insertMeta("stf:exponent", openvdb::Int32Metadata(exponent));
    grid->setSaveFloatAsHalf(!part.columns);
    return grid;
}

// Rms of the rounding to half of a field's values over directions, relative to them.
double roundingError(const FactoredField& f) {
    if (f.empty()) {
        return 0;
    }
    const int rank = f.rank, width = f.components, groups = width / 3;
    std::vector<int> exponents;
    for (int k = 0; k < rank; ++k) {
        for (int g = 0; g < groups; ++g) {
            exponents.push_back(exponentOf(group(f, k, g)));
        }
    }
    // The sum over directions of (sum over k of a_k b_k)^2 is a' (B' B) a.
    std::vector<double> gram(std::size_t(rank) * std::size_t(rank), 0.0);
    for (int d = 0; d < f.directions; ++d) {
        const float* const b = f.basis.data() + std::size_t(d) * std::size_t(rank);
        for (int k = 0; k < rank; ++k) {
            for (int l = 0; l < rank; ++l) {
                gram[std::size_t(k * rank + l)] += double(b[k]) * double(b[l]);
            }
        }
    }
    const auto energy = [&](const std::vector<double>& a) {
        double sum = 0;
        for (int k = 0; k < rank; ++k) {
            for (int l = 0; l < rank; ++l) {
                sum += a[std::size_t(k)] * a[std::size_t(l)] * gram[std::size_t(k * rank + l)];
            }
        }
        return sum;
    };
    // Some items, scattered over all of them, tell enough.
    const std::size_t items = f.items(), looked = std::min<std::size_t>(items, 16384);
    double error = 0, whole = 0;
    std::vector<double> value(static_cast<std::size_t>(rank)), change(static_cast<std::size_t>(rank));
    for (std::size_t i = 0; i < looked; ++i) {
        const std::size_t item = looked == items ? i : i * 2654435761u % items;
        for (int c = 0; c < width; ++c) {
            for (int k = 0; k < rank; ++k) {
                const float v =
                    f.factors[(item * std::size_t(rank) + std::size_t(k)) * std::size_t(width) + std::size_t(c)];
                const int e = exponents[std::size_t(k * groups + c / 3)];
                const float scaled = std::ldexp(v, -e);
                value[std::size_t(k)] = double(v);
                change[std::size_t(k)] = std::ldexp(double(float(openvdb::math::half(scaled))) - double(scaled), e);
            }
            error += energy(change);
            whole += energy(value);
        }
    }
    return whole > 0 ? std::sqrt(std::max(0.0, error) / whole) : 0;
}

void check(const StfTable& t) {
    if (minComponent(t.size) < 1 || t.directions.count() < 1) {
        throw Error("the table has no size");
    }
    const std::size_t columns = product({t.size.x, t.size.y, 1});
    for (const Part& part : kParts) {
        const FactoredField& f = *(t.*part.field);
        const std::size_t rank = std::size_t(f.rank), items = product(sizeOf(part, t.size));
        const int directions = part.allDirections ? t.directions.count() : 1;
        if (f.empty()) {
            continue;
        }
        if ((f.components != 3 && f.components != 12) || f.directions != directions || f.rank > directions ||
            f.factors.size() != items * rank * std::size_t(f.components) ||
            f.basis.size() != std::size_t(f.directions) * rank) {
            throw Error(std::string("part '") + part.name + "' does not have the table's size");
        }
        if (!allFinite(f.factors) || !allFinite(f.basis)) {
            throw Error(std::string("part '") + part.name + "' holds values that are not finite");
        }
    }
    if ((!t.reflectedBelow.empty() && t.reflectedBelow.size() != columns) ||
        (!t.emittedBelow.empty() && t.emittedBelow.size() != columns) ||
        (!t.reflectedAbove.empty() && t.reflectedAbove.size() != std::size_t(t.directions.count()))) {
        throw Error("a map of columns does not have the table's size");
    }
    if (!allFinite(t.reflectedBelow) || !allFinite(t.emittedBelow) || !allFinite(t.reflectedAbove)) {
        throw Error("a map of columns holds values that are not finite");
    }
}

openvdb::MetaMap header(const StfTable& t, const std::string& key) {
    openvdb::MetaMap m;
    const auto vec3d = [](double x, double y, double z) { return openvdb::Vec3DMetadata(openvdb::Vec3d(x, y, z)); };
    m.insertMeta("stf:table_version", openvdb::Int32Metadata(kTableVersion));
    m.insertMeta("stf:key", openvdb::StringMetadata(key));
    m.insertMeta("stf:size", openvdb::Vec3IMetadata(openvdb::Vec3i(t.size.x, t.size.y, t.size.z)));
    m.insertMeta("stf:voxel_mm", vec3d(t.voxelMm.x, t.voxelMm.y, t.voxelMm.z));
    m.insertMeta("stf:polars", openvdb::Int32Metadata(t.directions.polars()));
    m.insertMeta("stf:azimuths", openvdb::Int32Metadata(t.directions.azimuths()));
    m.insertMeta("stf:top_ior", openvdb::FloatMetadata(t.directions.topIor()));
    m.insertMeta("stf:form", openvdb::StringMetadata(name(t.form)));
    m.insertMeta("stf:volume_hash", openvdb::StringMetadata(t.volumeHash));
    m.insertMeta("stf:transmitted_up",
                 vec3d(double(t.transmittedUp.x), double(t.transmittedUp.y), double(t.transmittedUp.z)));
    m.insertMeta("stf:photons", openvdb::Int64Metadata(std::int64_t(t.photons)));
    m.insertMeta("stf:seed", openvdb::Int64Metadata(std::int64_t(t.seed)));
    m.insertMeta("stf:collisions", openvdb::Int64Metadata(std::int64_t(t.collisions)));
    m.insertMeta("stf:algorithm", openvdb::Int32Metadata(t.algorithm));
    m.insertMeta("stf:seconds", openvdb::DoubleMetadata(t.seconds));
    TableError error = t.error;
    error.storage = roundingError(*t.multiple);
    for (const NumberMeta& e : kErrors) {
        m.insertMeta(e.key, openvdb::DoubleMetadata(error.*e.value));
    }
    for (const Part& part : kParts) {
        const FactoredField& f = *(t.*part.field);
        if (!f.empty()) {
            m.insertMeta(std::string("stf:") + part.name,
                         openvdb::Vec3IMetadata(openvdb::Vec3i(f.rank, f.components, f.directions)));
        }
    }
    return m;
}

// ---- reading

std::vector<Rgb> readRgb(const IndexedVdb& file, const std::string& name, const Vec3i& size) {
    std::vector<Rgb> values = readRgbGrid({file.grid(name)}, name, size);
    if (!allFinite(values)) {
        throw Error("grid '" + name + "' holds values that are not finite");
    }
    return values;
}

// The factors of a part whose basis is there.
FactoredField readFactors(const IndexedVdb& file, const Part& part, FactoredField field, const Vec3i& size) {
    const std::size_t width = std::size_t(field.components), stride = width * std::size_t(field.rank);
    const std::size_t items = product(size);
    const int groups = field.components / 3;
    field.factors.resize(items * stride);
    const auto read = [&](int k, int g) {
        const std::string gridsName = gridName(part.name, k, g);
        const openvdb::GridBase::Ptr grid = file.grid(gridsName);
        const int exponent = requiredMeta<openvdb::Int32Metadata>(*grid, "stf:exponent");
        std::vector<Rgb> values = readRgbGrid({grid}, gridsName, size);
        scaleBy(values, exponent);
        if (!allFinite(values)) {
            throw Error("grid '" + gridsName + "' holds values that are not finite");
        }
        float* p = field.factors.data() + std::size_t(k) * width + std::size_t(g) * 3;
        for (std::size_t i = 0; i < items; ++i, p += stride) {
            p[0] = values[i].x, p[1] = values[i].y, p[2] = values[i].z;
        }
    };
    // An exception that left the loop would cancel OpenVDB's loops in the other bodies.
    std::vector<std::exception_ptr> errors(std::size_t(field.rank * groups));
    parallelFor(errors.size(), 1, [&](std::size_t i, std::size_t) {
        try {
            read(int(i) / groups, int(i) % groups);
        } catch (...) {
            errors[i] = std::current_exception();
        }
    });
    for (const std::exception_ptr& error : errors) {
        if (error) {
            std::rethrow_exception(error);
        }
    }
    return field;
}

// Errors that do not name the file yet do so afterwards.
template<class Read>
auto namingTheFile(const std::string& path, Read read) {
    try {
        return read();
    } catch (const std::exception& e) {
        const std::string text = e.what();
        throw Error(text.compare(0, path.size(), path) == 0 ? text : path + ": " + text);
    }
}

StfTable readHeader(const openvdb::MetaMap& m, const std::string& key) {
    if (requiredMeta<openvdb::Int32Metadata>(m, "stf:table_version") != kTableVersion) {
        throw Error("the table is of another version");
    }
    if (!key.empty() && requiredMeta<openvdb::StringMetadata>(m, "stf:key") != key) {
        throw Error("the table was made for something else");
    }
    StfTable t;
    const openvdb::Vec3i size = requiredMeta<openvdb::Vec3IMetadata>(m, "stf:size");
    const openvdb::Vec3d voxel = requiredMeta<openvdb::Vec3DMetadata>(m, "stf:voxel_mm");
    const openvdb::Vec3d up = requiredMeta<openvdb::Vec3DMetadata>(m, "stf:transmitted_up");
    const int polars = requiredMeta<openvdb::Int32Metadata>(m, "stf:polars");
    const int azimuths = requiredMeta<openvdb::Int32Metadata>(m, "stf:azimuths");
    t.size = {size[0], size[1], size[2]};
    t.voxelMm = {voxel[0], voxel[1], voxel[2]};
    t.transmittedUp = {float(up[0]), float(up[1]), float(up[2])};
    // Before anything is allocated.
    if (minComponent(t.size) < 1 || double(size[0]) * double(size[1]) * double(size[2]) > double(kMaxVoxels) ||
        polars < 1 || azimuths < 1 || (azimuths > 1 && azimuths % 2 != 0) ||
        double(polars) * double(azimuths) > double(kMostDirections)) {
        throw Error("the table has an impossible size");
    }
    if (!(minComponent(t.voxelMm) > 0) || !isFinite(t.voxelMm) || !isFinite(t.transmittedUp)) {
        throw Error("the table's header holds values that are not usable");
    }
    const float topIor = requiredMeta<openvdb::FloatMetadata>(m, "stf:top_ior");
    if (!(topIor >= 1) || !std::isfinite(topIor)) {
        throw Error("the table's header holds values that are not usable");
    }
    t.directions = DirectionSet(polars, azimuths, topIor);
    t.form = parseTransportForm(requiredMeta<openvdb::StringMetadata>(m, "stf:form"));
    t.volumeHash = requiredMeta<openvdb::StringMetadata>(m, "stf:volume_hash");
    t.photons = std::uint64_t(requiredMeta<openvdb::Int64Metadata>(m, "stf:photons"));
    t.seed = std::uint64_t(requiredMeta<openvdb::Int64Metadata>(m, "stf:seed"));
    t.collisions = std::uint64_t(requiredMeta<openvdb::Int64Metadata>(m, "stf:collisions"));
    t.algorithm = requiredMeta<openvdb::Int32Metadata>(m, "stf:algorithm");
    t.seconds = requiredMeta<openvdb::DoubleMetadata>(m, "stf:seconds");
    for (const NumberMeta& e : kErrors) {
        t.error.*e.value = requiredMeta<openvdb::DoubleMetadata>(m, e.key);
    }
    return t;
}

// The part without its factors; empty where the file has none.
FactoredField readBasis(const IndexedVdb& file, const Part& part, const DirectionSet& directions) {
    FactoredField field;
    const std::string key = std::string("stf:") + part.name;
    if (!file.metadata()[key]) {
        return field;
    }
    const openvdb::Vec3i shape = requiredMeta<openvdb::Vec3IMetadata>(file.metadata(), key.c_str());
    field.rank = shape[0], field.components = shape[1], field.directions = shape[2];
    if (field.directions != (part.allDirections ? directions.count() : 1) || field.rank < 1 ||
        field.rank > field.directions || (field.components != 3 && field.components != 12)) {
        throw Error(std::string("part '") + part.name + "' has an impossible size");
    }
    const std::string name = std::string(part.name) + "_basis";
    field.basis = readFloatGrid({file.grid(name)}, name, {field.rank, field.directions, 1});
    if (!allFinite(field.basis)) {
        throw Error("grid '" + name + "' holds values that are not finite");
    }
    for (int k = 0; k < field.rank; ++k) {
        for (int g = 0; g < field.components / 3; ++g) {
            if (!file.has(gridName(part.name, k, g))) {
                throw Error("grid '" + gridName(part.name, k, g) + "' is missing");
            }
        }
    }
    return field;
}

StfTable read(const std::string& path, const std::string& key) {
    const auto file = std::make_shared<const IndexedVdb>(path);
    StfTable t = readHeader(file->metadata(), key);
    const auto map = [&](const char* mapName, const Vec3i& mapSize) {
        return file->has(mapName) ? readRgb(*file, mapName, mapSize) : std::vector<Rgb>();
    };
    t.reflectedBelow = map("reflected_below", {t.size.x, t.size.y, 1});
    t.emittedBelow = map("emitted_below", {t.size.x, t.size.y, 1});
    t.reflectedAbove = map("reflected_above", {t.directions.count(), 1, 1});
    std::size_t bytes = t.bytes();
    for (const Part& part : kParts) {
        FactoredField basis = readBasis(*file, part, t.directions);
        if (basis.empty()) {
            continue;
        }
        const Vec3i size = sizeOf(part, t.size);
        bytes +=
            basis.bytes() + product(size) * std::size_t(basis.rank) * std::size_t(basis.components) * sizeof(float);
        t.*part.field = Lazy<FactoredField>([file, path, &part, size, basis = std::move(basis)] {
            FactoredField field;
            alone([&] { field = namingTheFile(path, [&] { return readFactors(*file, part, basis, size); }); });
            return field;
        });
    }
    t.headerBytes = bytes;
    t.fileBytes = file->fileBytes();
    return t;
}

} // namespace

void writeTable(const StfTable& t, const std::string& key, const std::string& path) {
    initializeOpenVdb();
    namingTheFile(path, [&] { check(t); });
    std::vector<IndexedVdb::MakeGrid> grids;
    const auto add = [&](const std::vector<Rgb>& values, const Vec3i& size, const char* name) {
        if (!values.empty()) {
            grids.emplace_back([&values, size, &t, name] { return toGrid(values, size, t.voxelMm, name); });
        }
    };
    add(t.reflectedBelow, {t.size.x, t.size.y, 1}, "reflected_below");
    add(t.emittedBelow, {t.size.x, t.size.y, 1}, "emitted_below");
    add(t.reflectedAbove, {t.directions.count(), 1, 1}, "reflected_above");
    for (const Part& part : kParts) {
        const FactoredField& f = *(t.*part.field);
        if (f.empty()) {
            continue;
        }
        grids.emplace_back([&f, &part, &t] {
            return toGrid(f.basis, {f.rank, f.directions, 1}, t.voxelMm, std::string(part.name) + "_basis");
        });
        for (int k = 0; k < f.rank; ++k) {
            for (int g = 0; g < f.components / 3; ++g) {
                grids.emplace_back([&f, &part, &t, k, g] { return factorGrid(part, f, k, g, t); });
            }
        }
    }
    const openvdb::MetaMap metadata = header(t, key);
    alone([&] { IndexedVdb::write(path, metadata, grids); });
}

StfTable readTable(const std::string& path, const std::string& key) {
    StfTable t;
    alone([&] { t = namingTheFile(path, [&] { return read(path, key); }); });
    return t;
}

} // namespace stf
