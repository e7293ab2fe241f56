// SPDX-License-Identifier: Apache-2.0
// The kd-tree of photons, in the only file that uses FLANN, which builds the tree. The nodes are
// then copied through FLANN's archive interface to an array of half their size, above a copy of the
// rows in the tree's order (photon_index_tree.h), and FLANN's memory is freed. Photons in
// Morton order are split into cells first; FLANN builds a tree for each cell, on all threads, and
// these are joined below the planes between the cells. FLANN's own search is not used
// (photon_index_search.cpp), because it allocates in every query, so that every lookup of light
// could fail, and its C functions start threads. Here nothing is allocated after the tree is built.
//
// FLANN is used only as was tested: one exact tree and no random seed.
#include <stdio.h>
#include <stdlib.h>

#include <algorithm>
#include <atomic>
#include <climits>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <new>
#include <vector>

extern "C" {
#include "base/array.h"
#include "base/bytes.h"
#include "base/parallel.h"
#include "photon/photon_index_tree.h"
#include "photon/photon_morton.h"
}

// FLANN's pool, which is in a header too, does not check the result of malloc. Here malloc throws
// std::bad_alloc, which FLANN passes on like its own.
static void *malloc_or_throw(size_t bytes) {
    void *memory = malloc(bytes);
    if (!memory) throw std::bad_alloc();
    return memory;
}
#define malloc malloc_or_throw
#include <flann/util/allocator.h>
#undef malloc
#include <flann/algorithms/kdtree_single_index.h>

namespace {

enum {
    // Largest number of rows of a cell for photons in Morton order: some hundred cells of
    // 200 thousand photons keep 64 threads busy, and the planes between them do not measurably slow
    // down queries.
    CELL_ROWS = 2048
};

struct Tree {
    float low[PHOTON_INDEX_COLUMNS], high[PHOTON_INDEX_COLUMNS];  // bounds of the rows
    std::vector<photon_index_node> node;
    std::vector<int> row;  // in the tree's order
};

// FLANN's interface of a distance; only its types are used in building.
template <size_t N>
struct Squared {
    typedef bool is_kdtree_distance;
    typedef float ElementType;
    typedef float ResultType;

    template <typename A, typename B>
    float operator()(A a, B b, size_t, float = -1.0f) const {
        float sum = 0.0f;
        for (size_t i = 0; i < N; i++) sum += (a[i] - b[i]) * (a[i] - b[i]);
        return sum;
    }

    float accum_dist(float a, float b, int) const { return (a - b) * (a - b); }
};

// Receives the tree as FLANN writes it: whether rows are copied, the rows of a leaf, the bounds,
// the order of the rows; then for each node the range of its rows, its column, its two limits, and
// whether it is a leaf.
class Reader final : public flann::serialization::OutputArchive<Reader> {
   public:
    explicit Reader(Tree &tree) : tree_(tree) {}

    template <typename T>
    Reader &operator&(const T &value) {
        flann::serialization::Serializer<T>::save(*this, value);
        return *this;
    }
    // The rows and the parameters are known already.
    template <typename D>
    Reader &operator&(const flann::NNIndex<D> &) {
        return *this;
    }
    Reader &operator&(const flann::Matrix<float> &) { return *this; }
    Reader &operator&(const std::vector<int> &order) {
        tree_.row = order;
        return *this;
    }

    void save(int value) {
        if (in_tree()) number_[numbers_++] = value;
    }
    void save(unsigned long) {}  // sizes
    void save(float value) {
        if (in_tree()) {
            limit_[limits_++] = value;
        } else {
            // By a pointer: gcc 12 takes a wrong index into (a ? b : c)[i] with -fsanitize=bounds.
            float *limit = bounds_ % 2 ? tree_.high : tree_.low;
            limit[bounds_ / 2] = value;
            bounds_++;
        }
    }
    void save(bool leaf) {
        if (in_tree()) add(leaf);
    }

   private:
    bool in_tree() const { return !tree_.row.empty(); }

    void add(bool leaf);

    Tree &tree_;
    std::vector<uint32_t> open_;  // nodes whose second child is still to come
    int bounds_ = 0, numbers_ = 0, limits_ = 0;
    int number_[3];
    float limit_[2];
};

// Ends a node. After a leaf comes the second child of the last node that lacks one.
void Reader::add(bool leaf) {
    const uint32_t at = static_cast<uint32_t>(tree_.node.size());
    if (at > 0 && tree_.node.back().column < 0) {
        tree_.node[open_.back()].second = at;
        open_.pop_back();
    }
    photon_index_node node = {leaf ? -1 : number_[2], 0, {limit_[0]}, {limit_[1]}};
    if (leaf) {
        node.begin = number_[0];
        node.end = number_[1];
    } else {
        open_.push_back(at);
    }
    tree_.node.push_back(node);
    numbers_ = limits_ = 0;
}

template <size_t N>
void build_tree(const float *data, size_t rows, Tree &out) {
    flann::KDTreeSingleIndex<Squared<N>> tree(
        flann::Matrix<float>(const_cast<float *>(data), rows, N),
        flann::KDTreeSingleIndexParams(PHOTON_INDEX_LEAF, false));
    tree.buildIndex();
    Reader reader(out);
    tree.serialize(reader);
}

// A cell of the rows, and the offset of its tree.
struct Cell {
    size_t begin, end;  // rows
    size_t first_node;
    Tree tree;
};

struct Building {
    photon_index *index;
    const float *data;
    std::vector<Cell> cell;
    std::atomic<bool> failed;
};

template <size_t N>
void build_cells(void *ctx, size_t begin, size_t end, int) {
    Building &b = *static_cast<Building *>(ctx);
    try {
        for (size_t i = begin; i < end; i++) {
            Cell &cell = b.cell[i];
            build_tree<N>(b.data + cell.begin * N, cell.end - cell.begin, cell.tree);
        }
    } catch (...) {  // no memory: FLANN throws nothing else here
        b.failed = true;
    }
}

// The trees of cells as bytes.
void pack_cells(void *ctx, size_t begin, size_t end, struct bytes *out) {
    const Building &b = *static_cast<Building *>(ctx);
    out->failed = out->failed || b.failed;
    for (size_t i = begin; i < end && !out->failed; i++) {
        const Tree &tree = b.cell[i].tree;
        bytes_put(out, tree.low, sizeof tree.low);
        bytes_put(out, tree.high, sizeof tree.high);
        bytes_put_u64(out, tree.node.size());
        bytes_put(out, tree.node.data(), tree.node.size() * sizeof(photon_index_node));
        bytes_put(out, tree.row.data(), tree.row.size() * sizeof(int));
    }
}

bool unpack_cells(void *ctx, size_t begin, size_t end, struct bytes_reader *in) {
    Building &b = *static_cast<Building *>(ctx);
    try {
        for (size_t i = begin; i < end; i++) {
            Tree &tree = b.cell[i].tree;
            bytes_get(in, tree.low, sizeof tree.low);
            bytes_get(in, tree.high, sizeof tree.high);
            const uint64_t nodes = bytes_get_u64(in);
            if (in->failed || nodes > in->left / sizeof(photon_index_node)) return false;
            tree.node.resize(nodes);
            tree.row.resize(b.cell[i].end - b.cell[i].begin);
            bytes_get(in, tree.node.data(), nodes * sizeof(photon_index_node));
            bytes_get(in, tree.row.data(), tree.row.size() * sizeof(int));
        }
    } catch (...) {  // no memory
        return false;
    }
    return true;
}

// Copies the rows of a leaf of the cell from row `first` on, column by column.
template <size_t N>
void copy_leaf(photon_index &index, const float *data, size_t first,
               const photon_index_node &leaf) {
    const size_t begin = first + static_cast<size_t>(leaf.begin);
    const size_t count = static_cast<size_t>(leaf.end - leaf.begin);
    float *out = index.data + begin * N;
    for (size_t k = 0; k < N; k++)
        for (size_t i = 0; i < count; i++)
            *out++ = data[static_cast<size_t>(index.row[begin + i]) * N + k];
}

// Copies the trees of cells to their offsets.
template <size_t N>
void join_cells(void *ctx, size_t begin, size_t end, int) {
    Building &b = *static_cast<Building *>(ctx);
    photon_index &index = *b.index;
    for (size_t i = begin; i < end; i++) {
        Cell &cell = b.cell[i];
        const int shift = static_cast<int>(cell.begin);
        photon_index_node *to = index.node + cell.first_node;
        for (photon_index_node node : cell.tree.node) {
            if (node.column < 0) {
                node.begin += shift;
                node.end += shift;
            } else {
                node.second += static_cast<uint32_t>(cell.first_node);
            }
            *to++ = node;
        }
        size_t at = cell.begin;
        for (int from : cell.tree.row) index.row[at++] = shift + from;
        for (const photon_index_node &node : cell.tree.node)
            if (node.column < 0) copy_leaf<N>(index, b.data, cell.begin, node);
        cell.tree = Tree();
    }
}

struct Box {
    float low[PHOTON_INDEX_COLUMNS], high[PHOTON_INDEX_COLUMNS];
};

// Assigns offsets to the nodes of the top of the tree, from top node `at` on, above the finished
// trees of the cells. Sets the top nodes and returns the bounds of the subtree. *next is the next
// free node.
template <size_t N>
Box lay_out(Building &b, const photon_morton_tree &top, size_t at, size_t *cell, size_t *next) {
    const photon_morton_node &node = top.node[at];
    Box box;
    if (node.column < 0) {
        Cell &here = b.cell[(*cell)++];
        here.first_node = *next;
        *next += here.tree.node.size();
        std::copy(here.tree.low, here.tree.low + N, box.low);
        std::copy(here.tree.high, here.tree.high + N, box.high);
        return box;
    }
    photon_index_node &out = b.index->node[(*next)++];
    box = lay_out<N>(b, top, at + 1, cell, next);
    out.column = node.column;
    out.low = box.high[node.column];
    out.second = static_cast<uint32_t>(*next);
    const Box other = lay_out<N>(b, top, node.second, cell, next);
    out.high = other.low[node.column];
    for (size_t k = 0; k < N; k++) {
        box.low[k] = std::min(box.low[k], other.low[k]);
        box.high[k] = std::max(box.high[k], other.high[k]);
    }
    return box;
}

template <typename T>
T *allocate_array(size_t count) {
    return static_cast<T *>(array_new_unset(count, sizeof(T)));
}

// Builds the whole tree. False if there is no memory or the pool was cancelled.
template <size_t N>
bool build_arrays(photon_index &index, const float *data, const photon_morton_tree &top,
                  struct parallel *pool) {
    Building b = {&index, data, {}, {false}};
    for (size_t i = 0; i < top.count; i++)
        if (top.node[i].column < 0) b.cell.push_back({top.node[i].begin, top.node[i].end, 0, {}});
    parallel_results trees{};
    trees.pack = pack_cells;
    trees.unpack = unpack_cells;
    if (!parallel_for_results(pool, b.cell.size(), 1, build_cells<N>, &b, &trees) || b.failed)
        return false;
    index.nodes = top.count - top.cells;
    for (const Cell &cell : b.cell) index.nodes += cell.tree.node.size();
    index.node = allocate_array<photon_index_node>(index.nodes);
    index.row = allocate_array<int>(index.rows);
    index.data = allocate_array<float>(index.rows * N + PHOTON_INDEX_LANES);
    if (!index.node || !index.row || !index.data) return false;
    std::fill_n(index.data + index.rows * N, +PHOTON_INDEX_LANES,
                0.0f);  // the lanes after the last leaf
    size_t cell = 0, next = 0;
    const Box box = lay_out<N>(b, top, 0, &cell, &next);
    std::copy(box.low, box.low + N, index.low);
    std::copy(box.high, box.high + N, index.high);
    return parallel_for(pool, b.cell.size(), 1, join_cells<N>, &b);
}

}  // namespace

struct photon_index *photon_index_new(const float *data, size_t rows, int columns,
                                      const struct photon_morton *morton, struct parallel *pool) {
    if (rows == 0 || rows > INT_MAX || (columns != 3 && columns != 6)) return nullptr;
    photon_index *index = nullptr;
    photon_morton_node whole = {-1, 0, 0, rows};
    photon_morton_tree top = {nullptr, 0, 0}, one = {&whole, 1, 1};
    bool built = !morton || photon_morton_split(morton, data, static_cast<size_t>(columns), rows,
                                                CELL_ROWS, &top);
    try {
        index = new photon_index{};
        index->columns = static_cast<size_t>(columns);
        index->rows = rows;
        const photon_morton_tree &above = morton ? top : one;
        if (built)
            built = columns == 3 ? build_arrays<3>(*index, data, above, pool)
                                 : build_arrays<6>(*index, data, above, pool);
    } catch (...) {  // no memory
        built = false;
    }
    free(top.node);
    if (built) return index;
    photon_index_free(index);
    return nullptr;
}

void photon_index_free(struct photon_index *index) {
    if (!index) return;
    free(index->node);
    free(index->row);
    free(index->data);
    delete index;
}

size_t photon_index_bytes(const struct photon_index *index) {
    if (!index) return 0;
    return sizeof *index + index->nodes * sizeof(photon_index_node) +
           index->rows * (sizeof(int) + index->columns * sizeof(float));
}
