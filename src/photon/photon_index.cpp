// SPDX-License-Identifier: Apache-2.0
// The kd-tree of photons, in the only file that uses FLANN, which builds the tree. The nodes are
// then copied through FLANN's archive interface to an array of half their size, above a copy of the
// rows in the tree's order, and FLANN's memory is freed. Photons along a curve are split into cells
// first; FLANN builds a tree for each cell, on all threads, and these are joined below the planes
// between the cells. The search has the same steps as FLANN's, so it finds the same rows in the
// same order. FLANN's own search is not used, because it allocates in every query, so that every
// lookup of light could fail, and its C functions start threads. Here nothing is allocated after
// the tree is built.
//
// FLANN is used only as was tested: one exact tree, no random seed, and no queries that are not
// finite.
#include <stdio.h>
#include <stdlib.h>

#include <algorithm>
#include <atomic>
#include <climits>
#include <cmath>
#include <cstdint>
#include <new>
#include <vector>

extern "C" {
#include "base/array.h"
#include "photon/photon_curve.h"
#include "photon/photon_index.h"
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
    LEAF_ROWS = 16,
    COLUMNS_MAX = 6,
    // Largest number of rows of a cell for photons along a curve: some hundred cells of 200
    // thousand photons keep 64 threads busy, and the planes between them do not measurably slow
    // down queries.
    CELL_ROWS = 2048
};

// Nodes are in the order in which FLANN writes the tree: a node, the subtree of its first child,
// that of the second.
struct Node {
    int32_t column;   // axis that separates the children; -1: a leaf
    uint32_t second;  // index of the second child
    union {
        float low;      // upper limit of the first child
        int32_t begin;  // of a leaf: first row
    };
    union {
        float high;   // lower limit of the second child
        int32_t end;  // of a leaf: end of its rows
    };
};

struct Tree {
    float low[COLUMNS_MAX], high[COLUMNS_MAX];  // bounds of the rows
    std::vector<Node> node;
    std::vector<int> row;  // in the tree's order
};

}  // namespace

struct photon_index {
    size_t columns;
    float low[COLUMNS_MAX], high[COLUMNS_MAX];  // bounds of the rows
    size_t nodes, rows;
    Node *node;
    int *row;     // in the tree's order
    float *data;  // the rows in the tree's order

    ~photon_index() {
        free(node);
        free(row);
        free(data);
    }
};

namespace {

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
            (bounds_ % 2 ? tree_.high : tree_.low)[bounds_ / 2] = value;
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
    Node node = {leaf ? -1 : number_[2], 0, {limit_[0]}, {limit_[1]}};
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
        flann::KDTreeSingleIndexParams(LEAF_ROWS, false));
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

// Copies the trees of cells to their offsets.
template <size_t N>
void join_cells(void *ctx, size_t begin, size_t end, int) {
    Building &b = *static_cast<Building *>(ctx);
    photon_index &index = *b.index;
    for (size_t i = begin; i < end; i++) {
        Cell &cell = b.cell[i];
        const int shift = static_cast<int>(cell.begin);
        Node *to = index.node + cell.first_node;
        for (Node node : cell.tree.node) {
            if (node.column < 0) {
                node.begin += shift;
                node.end += shift;
            } else {
                node.second += static_cast<uint32_t>(cell.first_node);
            }
            *to++ = node;
        }
        size_t at = cell.begin;
        for (int from : cell.tree.row) {
            const size_t row = cell.begin + static_cast<size_t>(from);
            index.row[at] = static_cast<int>(row);
            for (size_t k = 0; k < N; k++) index.data[at * N + k] = b.data[row * N + k];
            at++;
        }
        cell.tree = Tree();
    }
}

struct Box {
    float low[COLUMNS_MAX], high[COLUMNS_MAX];
};

// Assigns offsets to the nodes of the top of the tree, from top node `at` on, above the finished
// trees of the cells. Sets the top nodes and returns the bounds of the subtree. *next is the next
// free node.
template <size_t N>
Box lay_out(Building &b, const photon_curve_tree &top, size_t at, size_t *cell, size_t *next) {
    const photon_curve_node &node = top.node[at];
    Box box;
    if (node.column < 0) {
        Cell &here = b.cell[(*cell)++];
        here.first_node = *next;
        *next += here.tree.node.size();
        std::copy(here.tree.low, here.tree.low + N, box.low);
        std::copy(here.tree.high, here.tree.high + N, box.high);
        return box;
    }
    Node &out = b.index->node[(*next)++];
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
bool build_arrays(photon_index &index, const float *data, const photon_curve_tree &top,
                  struct parallel *pool) {
    Building b = {&index, data, {}, {false}};
    for (size_t i = 0; i < top.count; i++)
        if (top.node[i].column < 0) b.cell.push_back({top.node[i].begin, top.node[i].end, 0, {}});
    if (!parallel_for(pool, b.cell.size(), 1, build_cells<N>, &b) || b.failed) return false;
    index.nodes = top.count - top.cells;
    for (const Cell &cell : b.cell) index.nodes += cell.tree.node.size();
    index.node = allocate_array<Node>(index.nodes);
    index.row = allocate_array<int>(index.rows);
    index.data = allocate_array<float>(index.rows * N);
    if (!index.node || !index.row || !index.data) return false;
    size_t cell = 0, next = 0;
    const Box box = lay_out<N>(b, top, 0, &cell, &next);
    std::copy(box.low, box.low + N, index.low);
    std::copy(box.high, box.high + N, index.high);
    return parallel_for(pool, b.cell.size(), 1, join_cells<N>, &b);
}

// The result of a search for the nearest row.
struct Nearest {
    int row = -1;
    float distance2;

    explicit Nearest(float far2) : distance2(far2) {}

    void add(float dist, int at) {
        if (!(dist < distance2)) return;
        distance2 = dist;
        row = at;
    }
    float worst() const { return distance2; }
};

// The result of a search for the k nearest rows, in the caller's arrays. Once they are full, they
// are a heap with the farthest row on top.
class NearestK {
   public:
    NearestK(int k, float far2, int *row, float *distance2)
        : k_(k), far2_(far2), row_(row), distance2_(distance2) {}

    void add(float dist, int at) {
        if (count_ < k_) {
            row_[count_] = at;
            distance2_[count_++] = dist;
            if (count_ == k_)
                for (int i = k_ / 2; i-- > 0;) sink(i, distance2_[i], row_[i]);
        } else if (dist < distance2_[0]) {
            sink(0, dist, at);
        }
    }
    float worst() const { return count_ == k_ ? distance2_[0] : far2_; }
    int count() const { return count_; }

   private:
    // Inserts an entry at index i or below it.
    void sink(int i, float dist, int row) {
        for (int child; (child = 2 * i + 1) < k_; i = child) {
            if (child + 1 < k_ && distance2_[child + 1] > distance2_[child]) child++;
            if (!(distance2_[child] > dist)) break;
            distance2_[i] = distance2_[child];
            row_[i] = row_[child];
        }
        distance2_[i] = dist;
        row_[i] = row;
    }

    int k_, count_ = 0;
    float far2_;
    int *row_;
    float *distance2_;
};

float square(float x) { return x * x; }

// The state of one search.
template <size_t N, typename Found>
struct Search {
    const photon_index &index;
    const float *query;
    Found &found;
    float along2[N];  // by column, the terms of the squared distance from the box of the current
                      // node
};

template <size_t N, typename Found>
void visit_leaf(Search<N, Found> &s, const Node &leaf) {
    const float worst = s.found.worst();
    const float *row = s.index.data + static_cast<size_t>(leaf.begin) * N;
    for (int i = leaf.begin; i < leaf.end; i++, row += N) {
        float distance2 = 0.0f;
        for (size_t k = 0; k < N; k++) distance2 += square(s.query[k] - row[k]);
        if (distance2 < worst) s.found.add(distance2, s.index.row[static_cast<size_t>(i)]);
    }
}

// Visits a subtree. `distance2` is the squared distance of the query from the node's box.
template <size_t N, typename Found>
void visit_subtree(Search<N, Found> &s, uint32_t at, float distance2) {
    const Node &node = s.index.node[at];
    if (node.column < 0) {
        visit_leaf(s, node);
        return;
    }
    const float value = s.query[node.column];
    const bool first = (value - node.low) + (value - node.high) < 0.0f;
    const float cut = square(value - (first ? node.high : node.low));
    visit_subtree(s, first ? at + 1 : node.second, distance2);
    float &along2 = s.along2[node.column];
    const float before = along2;
    distance2 = distance2 + cut - before;
    along2 = cut;
    if (distance2 <= s.found.worst()) visit_subtree(s, first ? node.second : at + 1, distance2);
    along2 = before;
}

template <size_t N, typename Found>
void search_tree(const photon_index &index, const float *query, Found &found) {
    Search<N, Found> s = {index, query, found, {}};
    float distance2 = 0.0f;
    for (size_t i = 0; i < N; i++) {
        if (query[i] < index.low[i]) s.along2[i] = square(query[i] - index.low[i]);
        if (query[i] > index.high[i]) s.along2[i] = square(query[i] - index.high[i]);
        distance2 += s.along2[i];
    }
    if (distance2 <= found.worst()) visit_subtree(s, 0, distance2);
}

bool finite(const float *q, size_t n) {
    float sum = 0.0f;
    for (size_t i = 0; i < n; i++) sum += q[i] * 0.0f;
    return sum == 0.0f;
}

template <size_t N>
void find_nearest(const photon_index &index, const float *query, int k, float far2, int *row,
                  float *distance2) {
    if (k == 1) {
        Nearest nearest(far2);
        search_tree<N>(index, query, nearest);
        if (nearest.row < 0) return;
        row[0] = nearest.row;
        distance2[0] = nearest.distance2;
    } else {
        NearestK nearest(k, far2, row, distance2);
        search_tree<N>(index, query, nearest);
    }
}

}  // namespace

struct photon_index *photon_index_new(const float *data, size_t rows, int columns,
                                      const struct photon_curve *curve, struct parallel *pool) {
    if (rows == 0 || rows > INT_MAX || (columns != 3 && columns != 6)) return nullptr;
    photon_index *index = nullptr;
    photon_curve_node whole = {-1, 0, 0, rows};
    photon_curve_tree top = {nullptr, 0, 0}, one = {&whole, 1, 1};
    bool built = !curve || photon_curve_split(curve, data, static_cast<size_t>(columns), rows,
                                              CELL_ROWS, &top);
    try {
        index = new photon_index();
        index->columns = static_cast<size_t>(columns);
        index->rows = rows;
        const photon_curve_tree &above = curve ? top : one;
        if (built)
            built = columns == 3 ? build_arrays<3>(*index, data, above, pool)
                                 : build_arrays<6>(*index, data, above, pool);
    } catch (...) {  // no memory
        built = false;
    }
    free(top.node);
    if (built) return index;
    delete index;
    return nullptr;
}

void photon_index_free(struct photon_index *index) { delete index; }

size_t photon_index_bytes(const struct photon_index *index) {
    if (!index) return 0;
    return sizeof *index + index->nodes * sizeof(Node) +
           index->rows * (sizeof(int) + index->columns * sizeof(float));
}

void photon_index_nearest(const struct photon_index *index, const float *query, size_t count, int k,
                          float far2, int *row, float *distance2) {
    const size_t columns = index->columns;
    for (size_t i = 0; i < count; i++, query += columns, row += k, distance2 += k) {
        for (int j = 0; j < k; j++) {
            row[j] = -1;
            distance2[j] = INFINITY;
        }
        if (!finite(query, columns)) continue;
        if (columns == 3)
            find_nearest<3>(*index, query, k, far2, row, distance2);
        else
            find_nearest<6>(*index, query, k, far2, row, distance2);
    }
}

int photon_index_within(const struct photon_index *index, const float *query, int most, float r2,
                        int *row, float *distance2) {
    if (!finite(query, index->columns)) return 0;
    NearestK found(most, r2, row, distance2);
    if (index->columns == 3)
        search_tree<3>(*index, query, found);
    else
        search_tree<6>(*index, query, found);
    return found.count();
}
