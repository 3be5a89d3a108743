// SPDX-License-Identifier: Apache-2.0
#include "stfLib/base/error.h"
#include "stfLib/base/parallel.h"
#include "stfLib/base/random.h"
#include "stfLib/transport/indexed_vdb.h"
#include "stfLib/transport/stf_table.h"
#include "stfLib/volume/vdb_dense.h"
#include "tests/unit/support/files.h"

#include <atomic>
#include <chrono>
#include <thread>

using namespace stf;
using namespace stf::test;

namespace {

namespace fs = std::filesystem;

// The parts by name, so that each is looked at.
struct Named {
    const char* name;
    Lazy<FactoredField> StfTable::*field;
};
const Named kParts[] = {{"multiple", &StfTable::multiple},       {"single", &StfTable::single},
                        {"backlight", &StfTable::backlight},     {"emitted", &StfTable::emitted},
                        {"transmitted", &StfTable::transmitted}, {"direct", &StfTable::direct}};

bool inColumns(const Named& part) {
    return part.field == &StfTable::transmitted || part.field == &StfTable::direct;
}

FactoredField field(int rank, int components, int directions, int items, float scale) {
    CounterRng rng(1, std::uint64_t(rank * 100 + components));
    FactoredField f;
    f.rank = rank, f.components = components, f.directions = directions;
    f.factors.resize(std::size_t(items * rank * components));
    for (float& v : f.factors) {
        // Zeros are inactive in the file; many orders of magnitude, either sign.
        v = rng.uniform() < 0.2f ? 0.0f : (rng.uniform() - 0.3f) * std::exp(-12 * rng.uniform()) * scale;
    }
    f.basis.resize(std::size_t(directions * rank));
    for (std::size_t i = 0; i < f.basis.size(); ++i) {
        f.basis[i] = (rng.uniform() - 0.3f) / float(1 + i % std::size_t(rank)) / scale;
    }
    return f;
}

std::vector<Rgb> colours(int count, std::uint64_t stream) {
    CounterRng rng(2, stream);
    std::vector<Rgb> values;
    for (int i = 0; i < count; ++i) {
        values.emplace_back(rng.uniform(), i % 3 ? rng.uniform() : 0.0f, 1.0f);
    }
    return values;
}

StfTable made(const Vec3i& size = {9, 5, 11}) {
    StfTable t;
    t.size = size;
    t.voxelMm = {0.5, 0.25, 0.125};
    t.directions = DirectionSet(3, 4);
    t.form = TransportForm::Classic;
    const int n = t.directions.count(), columns = size.x * size.y, voxels = columns * size.z;
    t.multiple = field(5, 12, n, voxels, 1);
    t.single = field(9, 3, n, voxels, 5000);
    t.backlight = field(1, 12, 1, voxels, 1e30f);
    t.emitted = field(1, 3, 1, voxels, 1e-30f);
    t.transmitted = field(4, 3, n, columns, 1);
    t.direct = field(2, 3, n, columns, 1e-6f);
    t.reflectedBelow = colours(columns, 1);
    t.emittedBelow = colours(columns, 2);
    t.reflectedAbove = colours(n, 3);
    t.transmittedUp = {0.25f, 0.1f, 1};
    t.volumeHash = "abc";
    t.error = {0.02, 0.011, 0.012, 0.013, 0.014, 0.5};
    t.photons = 12345678901ull;
    t.seed = 0xfedcba9876543210ull;
    t.collisions = 98765432109ull;
    t.algorithm = 17;
    t.seconds = 1.5;
    return t;
}

// One of few grids, to be read very often.
StfTable small() {
    StfTable t = made({3, 2, 2});
    t.multiple = field(1, 3, 9, 12, 1);
    t.single = t.emitted = t.transmitted = t.backlight = FactoredField();
    t.direct = field(1, 3, 9, 6, 1);
    t.emittedBelow.clear();
    t.reflectedAbove.clear();
    return t;
}

void readAll(const StfTable& t) {
    for (const Named& part : kParts) {
        (t.*part.field).get();
    }
}

std::string readBytes(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}
void writeBytes(const std::string& path, const std::string& bytes) {
    std::ofstream(path, std::ios::binary | std::ios::trunc).write(bytes.data(), std::streamsize(bytes.size()));
}

bool startsWith(const std::string& text, const std::string& start) {
    return text.compare(0, start.size(), start) == 0;
}

// ---- what was written is read

TEST(TableIo, HeaderAndMapsAreExact) {
    const TemporaryFolder folder;
    const StfTable t = made();
    writeTable(t, "key", folder.file("t.vdb"));
    for (const char* key : {"key", ""}) { // no key: whatever it was made for
        const StfTable r = readTable(folder.file("t.vdb"), key);
        EXPECT_EQ(r.size, t.size);
        EXPECT_EQ(r.voxelMm, t.voxelMm);
        EXPECT_EQ(r.directions.polars(), 3);
        EXPECT_EQ(r.directions.azimuths(), 4);
        EXPECT_EQ(r.form, TransportForm::Classic);
        EXPECT_TRUE(r.reflectedBelow == t.reflectedBelow);
        EXPECT_TRUE(r.emittedBelow == t.emittedBelow);
        EXPECT_TRUE(r.reflectedAbove == t.reflectedAbove);
        EXPECT_EQ(r.transmittedUp, t.transmittedUp);
        EXPECT_EQ(r.volumeHash, t.volumeHash);
        EXPECT_EQ(r.error.target, t.error.target);
        EXPECT_EQ(r.error.noise, t.error.noise);
        EXPECT_EQ(r.error.directions, t.error.directions);
        EXPECT_EQ(r.error.truncation, t.error.truncation);
        EXPECT_EQ(r.error.filter, t.error.filter);
        EXPECT_EQ(r.photons, t.photons);
        EXPECT_EQ(r.seed, t.seed);
        EXPECT_EQ(r.collisions, t.collisions);
        EXPECT_EQ(r.algorithm, t.algorithm);
        EXPECT_EQ(r.seconds, t.seconds);
    }
}

// Columns and bases are exact. A factor of a voxel part is off by at most half a unit in the last of 11 binary digits,
// below 2^-26 of the largest value of its kind by a fixed part of that.
TEST(TableIo, FactorsAreExactOrRoundedToHalf) {
    const TemporaryFolder folder;
    const StfTable t = made();
    writeTable(t, "key", folder.file("t.vdb"));
    const StfTable r = readTable(folder.file("t.vdb"), "key");
    for (const Named& part : kParts) {
        const FactoredField &a = *(t.*part.field), &b = *(r.*part.field);
        ASSERT_EQ(b.rank, a.rank) << part.name;
        ASSERT_EQ(b.components, a.components);
        ASSERT_EQ(b.directions, a.directions);
        ASSERT_EQ(b.factors.size(), a.factors.size());
        EXPECT_TRUE(b.basis == a.basis) << part.name;
        if (inColumns(part)) {
            EXPECT_TRUE(b.factors == a.factors) << part.name;
            continue;
        }
        const std::size_t groups = std::size_t(a.components / 3), kinds = std::size_t(a.rank) * groups;
        std::vector<float> largest(kinds, 0.0f);
        for (std::size_t i = 0; i < a.factors.size(); ++i) {
            float& most = largest[i / 3 % kinds];
            most = std::max(most, std::abs(a.factors[i]));
        }
        for (std::size_t i = 0; i < a.factors.size(); ++i) {
            const double error = std::abs(double(b.factors[i]) - double(a.factors[i]));
            ASSERT_LE(error, 0x1p-11 * std::abs(double(a.factors[i])) + 0x1p-37 * double(largest[i / 3 % kinds]))
                << part.name << " " << i;
        }
        EXPECT_FALSE(b.factors == a.factors) << "half precision was asked for";
    }
    // Written again, what is in half precision does not change any more.
    writeTable(r, "key", folder.file("again.vdb"));
    const StfTable again = readTable(folder.file("again.vdb"), "key");
    for (const Named& part : kParts) {
        EXPECT_TRUE((again.*part.field)->factors == (r.*part.field)->factors) << part.name;
    }
    EXPECT_EQ(again.error.storage, 0);
}

TEST(TableIo, TellsTheRoundingOfTheField) {
    const TemporaryFolder folder;
    for (const int depth : {11, 700}) { // the latter: told from a part of the voxels
        const StfTable t = made({9, 5, depth});
        writeTable(t, "key", folder.file("t.vdb"));
        const StfTable r = readTable(folder.file("t.vdb"), "key");
        EXPECT_EQ(t.error.storage, 0.5) << "the table that was written did not change";
        double error = 0, whole = 0;
        const FactoredField &a = *t.multiple, &b = *r.multiple;
        for (std::size_t i = 0; i < a.items(); ++i) {
            for (int d = 0; d < a.directions; ++d) {
                for (int c = 0; c < 12; ++c) {
                    const double x = double(a.node(i, d, c)), y = double(b.node(i, d, c));
                    error += (x - y) * (x - y), whole += x * x;
                }
            }
        }
        const double expected = std::sqrt(error / whole);
        EXPECT_NEAR(r.error.storage / expected, 1, depth < 100 ? 2e-3 : 0.03);
        EXPECT_LT(r.error.storage, 3e-4);
        EXPECT_GT(r.error.storage, 5e-5);
    }
}

TEST(TableIo, TotalErrorIsTheRootOfTheSumOfSquares) {
    TableError e;
    e.target = 9;
    e.noise = 1, e.directions = 2, e.truncation = 4, e.filter = 8, e.storage = 16;
    EXPECT_DOUBLE_EQ(e.total(), std::sqrt(341.0));
}

TEST(TableIo, EmptyPartsStayEmpty) {
    const TemporaryFolder folder;
    StfTable t = made();
    t.single = t.emitted = t.direct = FactoredField();
    t.emittedBelow.clear();
    t.reflectedAbove.clear();
    t.form = TransportForm::DE1;
    writeTable(t, "key", folder.file("t.vdb"));
    const StfTable r = readTable(folder.file("t.vdb"), "key");
    EXPECT_EQ(r.form, TransportForm::DE1);
    EXPECT_TRUE(r.single->empty() && r.emitted->empty() && r.direct->empty());
    EXPECT_TRUE(r.single.made()) << "nothing to read";
    EXPECT_TRUE(r.emittedBelow.empty() && r.reflectedAbove.empty());
    EXPECT_EQ(r.multiple->rank, 5);
    EXPECT_EQ(r.bytes(), t.bytes());
    // Nothing at all but a size: a volume that does not scatter.
    StfTable bare;
    bare.size = {2, 2, 2};
    bare.directions = DirectionSet(1, 1);
    writeTable(bare, "", folder.file("bare.vdb"));
    const StfTable b = readTable(folder.file("bare.vdb"), "");
    readAll(b);
    EXPECT_EQ(b.bytes(), 0u);
    EXPECT_EQ(b.error.storage, 0);
}

TEST(TableIo, ZeroAndConstantPartsAreRead) {
    const TemporaryFolder folder;
    StfTable t = made({16, 16, 16}); // whole nodes of the file's tree are one value
    FactoredField zero = field(1, 3, 1, 4096, 1), constant = field(1, 12, 1, 4096, 1);
    std::fill(zero.factors.begin(), zero.factors.end(), 0.0f);
    std::fill(constant.factors.begin(), constant.factors.end(), 0.375f);
    t.emitted = zero;
    t.backlight = constant;
    writeTable(t, "key", folder.file("t.vdb"));
    const StfTable r = readTable(folder.file("t.vdb"), "key");
    EXPECT_TRUE(r.emitted->factors == zero.factors);
    EXPECT_TRUE(r.backlight->factors == constant.factors);
}

TEST(TableIo, ATableOfOneColumn) {
    const TemporaryFolder folder;
    for (int depth : {1, 7, 300}) {
        const StfTable t = made({1, 1, depth});
        writeTable(t, "key", folder.file("t.vdb"));
        const StfTable r = readTable(folder.file("t.vdb"), "key");
        EXPECT_EQ(r.multiple->items(), std::size_t(depth));
        EXPECT_TRUE(r.transmitted->factors == t.transmitted->factors);
        for (std::size_t i = 0; i < r.multiple->items(); ++i) {
            EXPECT_NEAR(r.multiple->node(i, 4, 0), t.multiple->node(i, 4, 0), 5e-4f);
        }
    }
}

// ---- parts are read when they are used

TEST(TableIo, ReadsPartsAtTheirFirstUse) {
    const TemporaryFolder folder;
    const StfTable t = made();
    writeTable(t, "key", folder.file("t.vdb"));
    const StfTable r = readTable(folder.file("t.vdb"), "key");
    EXPECT_EQ(r.bytes(), t.bytes());
    EXPECT_EQ(r.headerBytes, t.bytes());
    EXPECT_EQ(r.fileBytes, fs::file_size(folder.file("t.vdb")));
    EXPECT_EQ(t.fileBytes, 0u);
    for (const Named& part : kParts) {
        EXPECT_FALSE((r.*part.field).made()) << part.name;
    }
    const StfTable copy = r;
    EXPECT_EQ(r.multiple->rank, 5);
    EXPECT_TRUE(copy.multiple.made()) << "copies share it";
    EXPECT_FALSE(r.single.made());
    EXPECT_FALSE(r.transmitted.made());
    EXPECT_EQ(&r.multiple.get(), &copy.multiple.get());
}

TEST(TableIo, AFileThatIsGoneAtTheFirstUse) {
    const TemporaryFolder folder;
    const std::string path = folder.file("t.vdb"), away = folder.file("away.vdb");
    const StfTable t = made();
    writeTable(t, "key", path);
    const StfTable r = readTable(path, "key");
    fs::rename(path, away);
    for (int i = 0; i < 2; ++i) {
        const std::string text = messageOf<Error>([&] { r.multiple.get(); });
        EXPECT_TRUE(startsWith(text, path + ": ")) << text;
        EXPECT_EQ(text.find(path, 1), std::string::npos) << "named once: " << text;
        EXPECT_FALSE(r.multiple.made());
    }
    fs::rename(away, path);
    EXPECT_EQ(r.multiple->rank, 5);
    fs::remove(path);
    EXPECT_EQ(r.multiple->items(), 9u * 5 * 11) << "read once";
}

TEST(TableIo, AFileThatWasReplacedBeforeTheFirstUse) {
    const TemporaryFolder folder;
    const std::string path = folder.file("t.vdb");
    StfTable t = made();
    writeTable(t, "key", path);
    const StfTable r = readTable(path, "key");
    FactoredField other = *t.multiple;
    other.factors[40] *= 1.5f;
    t.multiple = other;
    writeTable(t, "key", path);
    EXPECT_THROW(r.multiple.get(), Error);
    writeTable(made({4, 4, 4}), "key", path);
    EXPECT_THROW(r.multiple.get(), Error);
    // The same table, made again: it took another time.
    t = made();
    t.seconds = 99;
    writeTable(t, "key", path);
    readAll(r);
}

TEST(TableIo, ManyThreadsAskForTheSamePart) {
    const TemporaryFolder folder;
    writeTable(made({32, 32, 24}), "key", folder.file("t.vdb"));
    for (int threads : {0, 4}) {
        setThreadCount(threads);
        const StfTable r = readTable(folder.file("t.vdb"), "key");
        std::atomic<int> right{0};
        // Loops inside loops: reading must not take up another of these that waits for the same part.
        parallelFor(64, 1, [&](std::size_t i, std::size_t) {
            parallelFor(8, 1, [&](std::size_t, std::size_t) {
                right += (i % 2 ? r.multiple : r.single)->rank == (i % 2 ? 5 : 9);
            });
        });
        EXPECT_EQ(right, 64 * 8);
    }
    setThreadCount(0);
}

// A loop that was cancelled cancels those inside it, OpenVDB's as well: what is read is whole all the same.
TEST(TableIo, ReadsWholePartsInACancelledLoop) {
    const TemporaryFolder folder;
    StfTable t = made({24, 24, 24});
    writeTable(t, "key", folder.file("t.vdb"));
    const StfTable whole = readTable(folder.file("t.vdb"), "key"), r = readTable(folder.file("t.vdb"), "key");
    std::atomic<bool> started{false}, over{false};
    StfTable second;
    EXPECT_THROW(parallelFor(2, 1,
                             [&](std::size_t i, std::size_t) {
                                 if (i == 0) {
                                     // Once the other one runs, or after a while where there is one thread only.
                                     for (int n = 0; n < 500 && !started; ++n) {
                                         std::this_thread::sleep_for(std::chrono::milliseconds(2));
                                     }
                                     throw Cancelled();
                                 }
                                 started = true;
                                 std::this_thread::sleep_for(std::chrono::milliseconds(100));
                                 second = readTable(folder.file("t.vdb"), "key");
                                 r.multiple.get();
                                 writeTable(t, "key", folder.file("written.vdb"));
                                 over = true;
                             }),
                 Cancelled);
    if (!over) {
        GTEST_SKIP() << "one thread: nothing was read in the loop";
    }
    EXPECT_TRUE(r.multiple->factors == whole.multiple->factors);
    EXPECT_TRUE(second.reflectedBelow == whole.reflectedBelow);
    EXPECT_TRUE(second.multiple->basis == whole.multiple->basis);
    EXPECT_TRUE(readTable(folder.file("written.vdb"), "key").multiple->factors == whole.multiple->factors);
}

// ---- damage

TEST(TableIo, RefusesAnotherKeyOrVersion) {
    const TemporaryFolder folder;
    const std::string path = folder.file("t.vdb");
    writeTable(made(), "key", path);
    const std::string text = messageOf<Error>([&] { readTable(path, "another"); });
    EXPECT_TRUE(startsWith(text, path + ": ")) << text;
    EXPECT_NE(text.find("something else"), std::string::npos) << text;
}

// Whatever byte is not as it was, somebody notices: nothing is taken for a table, nothing crashes.
TEST(TableIo, RefusesAnyDamagedByte) {
    const TemporaryFolder folder;
    const std::string path = folder.file("t.vdb");
    writeTable(small(), "key", path);
    const std::string whole = readBytes(path);
    ASSERT_GT(whole.size(), 5000u);
    const auto refused = [&](std::size_t at, const std::string& bytes) {
        writeBytes(path, bytes);
        const std::string text = messageOf<Error>([&] { readAll(readTable(path, "key")); });
        ASSERT_TRUE(startsWith(text, path + ": ")) << at << " " << text;
    };
    for (std::size_t at = 0; at < whole.size(); at += at < 1200 || at + 500 > whole.size() ? 3 : 211) {
        std::string bytes = whole;
        bytes[at] = char(bytes[at] ^ (1 << (at % 8)));
        refused(at, bytes);
    }
    for (std::size_t length : {16u, 400u}) {
        for (std::size_t at = 0; at + length <= whole.size(); at += 997) {
            for (char with : {'\0', '\xff'}) {
                std::string bytes = whole;
                bytes.replace(at, length, std::string(length, with));
                if (bytes != whole) {
                    refused(at, bytes);
                }
            }
        }
    }
    writeBytes(path, whole);
    readAll(readTable(path, "key"));
}

TEST(TableIo, DamageAfterTheHeaderWasRead) {
    const TemporaryFolder folder;
    const std::string path = folder.file("t.vdb");
    const StfTable t = made();
    writeTable(t, "key", path);
    const std::string whole = readBytes(path);
    const StfTable r = readTable(path, "key");
    for (std::size_t length : {std::size_t(0), whole.size() / 3, whole.size() / 2}) {
        writeBytes(path, whole.substr(0, length));
        EXPECT_THROW(r.direct.get(), Error) << length;
    }
    writeBytes(path, whole.substr(0, whole.size() - 20));
    EXPECT_EQ(r.direct->rank, 2) << "what is needed is there";
}

TEST(TableIo, RefusesMissingTruncatedAndForeignFiles) {
    const TemporaryFolder folder;
    const std::string path = folder.file("t.vdb");
    EXPECT_THROW(readTable(path, ""), Error);
    EXPECT_THROW(readTable(folder.path().string(), ""), Error);
    writeTable(small(), "key", path);
    const std::string whole = readBytes(path);
    for (std::size_t length = 0; length<whole.size(); length += length + 200> whole.size() ? 1 : 131) {
        writeBytes(path, whole.substr(0, length));
        const std::string text = messageOf<Error>([&] { readAll(readTable(path, "key")); });
        ASSERT_TRUE(startsWith(text, path + ": ")) << length << " " << text;
    }
    writeBytes(path, whole + "more");
    EXPECT_THROW(readTable(path, "key"), Error);
    writeBytes(path, "no table");
    EXPECT_THROW(readTable(path, "key"), Error);
    // A .vdb that is no table.
    writeVdb(path, {toGrid(colours(8, 1), {2, 2, 2}, {1, 1, 1}, "extinction")}, {});
    EXPECT_THROW(readTable(path, ""), Error);
}

// ---- headers that agree with their hash and make no sense

class TableHeader : public testing::Test {
protected:
    TableHeader() {
        // The pieces of a good table.
        writeTable(made({2, 2, 2}), "key", path);
        const IndexedVdb file(path);
        metadata = file.metadata();
        for (const auto& grid : readVdb(path).grids) {
            grids[grid->getName()] = grid;
        }
    }
    // What is said about the pieces as they are now.
    std::string said() {
        std::vector<IndexedVdb::MakeGrid> make;
        for (const auto& [name, grid] : grids) {
            make.emplace_back([g = grid] { return g; });
        }
        IndexedVdb::write(path, metadata, make);
        const std::string text = messageOf<Error>([&] { readAll(readTable(path, "")); });
        EXPECT_TRUE(startsWith(text, path + ": ")) << text;
        return text;
    }
    template<class Meta, class T>
    void set(const char* key, const T& value) {
        metadata.removeMeta(key);
        metadata.insertMeta(key, Meta(value));
    }

    TemporaryFolder folder;
    const std::string path = folder.file("t.vdb");
    openvdb::MetaMap metadata;
    std::map<std::string, openvdb::GridBase::Ptr> grids;
};

TEST_F(TableHeader, PiecesAreATable) {
    std::vector<IndexedVdb::MakeGrid> make;
    for (const auto& [name, grid] : grids) {
        make.emplace_back([g = grid] { return g; });
    }
    IndexedVdb::write(path, metadata, make);
    readAll(readTable(path, "key"));
}

TEST_F(TableHeader, MissingOrOfAnotherType) {
    const openvdb::MetaMap good = metadata;
    for (auto it = good.beginMeta(); it != good.endMeta(); ++it) {
        const std::string key = it->first;
        if (key == "stf:key" || it->second->typeName() == openvdb::Vec3IMetadata::staticTypeName()) {
            continue; // not asked for here, or a part that is then absent
        }
        metadata = good;
        metadata.removeMeta(key);
        EXPECT_NE(said().find(key), std::string::npos) << key;
        metadata.insertMeta(key, openvdb::BoolMetadata(true));
        EXPECT_NE(said().find(key), std::string::npos) << key;
    }
}

TEST_F(TableHeader, OfAnotherVersion) {
    for (int version : {0, 1, 2, 4, -1}) {
        set<openvdb::Int32Metadata>("stf:table_version", version);
        EXPECT_NE(said().find("version"), std::string::npos);
    }
}

TEST_F(TableHeader, ImpossibleSizes) {
    const openvdb::MetaMap good = metadata;
    using openvdb::Vec3i;
    for (const Vec3i& size : {Vec3i(0, 2, 2), Vec3i(-2, -2, 2), Vec3i(2, 2, -1), Vec3i(1 << 30, 1 << 30, 1 << 30)}) {
        set<openvdb::Vec3IMetadata>("stf:size", size);
        said();
    }
    metadata = good;
    for (int n : {0, -1, 1 << 30, 0x7fffffff}) {
        set<openvdb::Int32Metadata>("stf:polars", n);
        said();
    }
    metadata = good;
    for (int n : {0, -1, 3, 1 << 30, 0x7ffffffe}) {
        set<openvdb::Int32Metadata>("stf:azimuths", n);
        said();
    }
    metadata = good;
    for (const Vec3i& shape : {Vec3i(0, 12, 9), Vec3i(-5, 12, 9), Vec3i(10, 12, 9), Vec3i(5, 4, 9), Vec3i(5, 12, 8),
                               Vec3i(5, 12, 0x7fffffff), Vec3i(6, 12, 9)}) {
        set<openvdb::Vec3IMetadata>("stf:multiple", shape);
        said();
    }
    metadata = good;
    set<openvdb::StringMetadata>("stf:form", "unheard-of");
    EXPECT_NE(said().find("unheard-of"), std::string::npos);
    metadata = good;
    set<openvdb::Vec3DMetadata>("stf:voxel_mm", openvdb::Vec3d(1, 0, 1));
    said();
    set<openvdb::Vec3DMetadata>("stf:voxel_mm", openvdb::Vec3d(1, std::nan(""), 1));
    said();
}

TEST_F(TableHeader, GridsThatAreMissingOfAnotherTypeOrNotFinite) {
    const auto good = grids;
    for (const char* name : {"multiple_003", "multiple_004_flux_z", "multiple_basis", "direct_001", "backlight_000"}) {
        grids = good;
        grids.erase(name);
        EXPECT_NE(said().find(name), std::string::npos);
        grids[name] = openvdb::Int32Grid::create();
        grids[name]->setName(name);
        grids[name]->insertMeta("stf:exponent", openvdb::Int32Metadata(0));
        EXPECT_NE(said().find(name), std::string::npos);
    }
    for (const char* name : {"multiple_000", "direct_000", "reflected_below", "reflected_above"}) {
        grids = good;
        const auto bad = openvdb::gridPtrCast<openvdb::Vec3SGrid>(grids[name])->deepCopy();
        bad->tree().setValue({0, 0, 0}, openvdb::Vec3s(1, std::nanf(""), 1));
        grids[name] = bad;
        EXPECT_NE(said().find("not finite"), std::string::npos) << name;
    }
    grids = good;
    grids["multiple_002"] = grids["multiple_002"]->deepCopyGrid();
    grids["multiple_002"]->removeMeta("stf:exponent");
    grids["multiple_002"]->insertMeta("stf:exponent", openvdb::Int32Metadata(2000000));
    EXPECT_NE(said().find("not finite"), std::string::npos);
}

// ---- files

TEST(TableIo, OtherToolsReadTheFile) {
    const TemporaryFolder folder;
    const std::string path = folder.file("t.vdb");
    const StfTable t = made();
    writeTable(t, "key", path);
    openvdb::io::File file(path);
    file.open(false);
    EXPECT_EQ(file.getMetadata()->metaValue<std::string>("stf:key"), "key");
    const auto grid = openvdb::gridPtrCast<openvdb::Vec3SGrid>(file.readGrid("multiple_003_flux_y"));
    ASSERT_TRUE(grid);
    EXPECT_TRUE(grid->saveFloatAsHalf());
    const int exponent = grid->metaValue<std::int32_t>("stf:exponent");
    const float value = t.multiple->factors[(t.voxelIndex(7, 3, 8) * 5 + 3) * 12 + 6];
    EXPECT_NEAR(std::ldexp(grid->tree().getValue({7, 3, 8}).x(), exponent), value, 5e-4f * std::abs(value) + 1e-12f);
    EXPECT_EQ(file.getGrids()->size(), 20u + 9 + 4 + 1 + 4 + 2 + 6 + 3);
    file.close();
}

TEST(TableIo, HalfPrecisionHalvesTheFile) {
    const TemporaryFolder folder;
    StfTable t = made({40, 40, 24});
    t.single = FactoredField();
    writeTable(t, "key", folder.file("t.vdb"));
    const StfTable r = readTable(folder.file("t.vdb"), "key");
    EXPECT_LT(double(r.fileBytes), 0.6 * double(r.bytes())); // a grid's own tree takes 10 kB
}

TEST(TableIo, RefusesToWriteWhatItCouldNotRead) {
    const TemporaryFolder folder;
    const std::string path = folder.file("t.vdb");
    const auto refused = [&](const StfTable& t) {
        const std::string text = messageOf<Error>([&] { writeTable(t, "key", path); });
        EXPECT_TRUE(startsWith(text, path + ": ")) << text;
        EXPECT_TRUE(fs::is_empty(folder.path()));
    };
    refused(StfTable());
    StfTable t = made();
    FactoredField bad = *t.multiple;
    bad.factors[7] = std::nanf("");
    t.multiple = bad;
    refused(t);
    bad.factors.pop_back();
    t.multiple = bad;
    refused(t);
    t = made();
    bad = *t.direct;
    bad.basis.push_back(1);
    t.direct = bad;
    refused(t);
    t = made();
    t.reflectedBelow.pop_back();
    refused(t);
    t = made();
    t.reflectedAbove[1].y = HUGE_VALF;
    refused(t);
}

TEST(TableIo, AFolderThatCannotBeWritten) {
    const TemporaryFolder folder;
    writeBytes(folder.file("file"), "");
    const std::string path = folder.file("file/t.vdb");
    const std::string text = messageOf<Error>([&] { writeTable(made(), "key", path); });
    EXPECT_TRUE(startsWith(text, path + ": ")) << text;
    // A new folder is made.
    writeTable(made(), "key", folder.file("new/folder/t.vdb"));
    EXPECT_EQ(std::distance(fs::directory_iterator(folder.path() / "new/folder"), {}), 1) << "nothing else is left";
}

} // namespace
