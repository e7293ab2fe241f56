// SPDX-License-Identifier: Apache-2.0
// The kd-tree of photons: the only file on FLANN, which builds the tree. Its archive interface then
// hands the nodes over into an array of half their size, over a copy of the rows in the tree's
// order, and FLANN's memory goes back. The search is FLANN's own, step by step, so it finds the
// same rows in the same order; but FLANN allocates in every query, and its C functions open a team
// of threads besides, and a query that can fail would have to be asked for its failure wherever
// light is looked up. Here nothing is allocated after the tree is built.
//
// FLANN is used within what was found to hold: one exact tree, no random seed, queries that are not
// finite kept out.
#include <stdio.h>
#include <stdlib.h>

#include <climits>
#include <cmath>
#include <cstdint>
#include <new>
#include <vector>

extern "C" {
#include "photon/photon_index.h"
}

// FLANN's pool, a header too, writes to what malloc returns without a look. Here malloc throws, and
// FLANN lets that pass as it does its own std::bad_alloc.
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

enum { LEAF_ROWS = 16, COLUMNS_MAX = 6 };

// Nodes stand in the order in which the tree is written down: first themselves, then their first
// child with all below it, then the second.
struct Node {
    int32_t column;   // that separates the children; -1: a leaf
    uint32_t second;  // node of the second child
    union {
        float low;      // where the first child ends
        int32_t begin;  // of a leaf's rows
    };
    union {
        float high;   // where the second child begins
        int32_t end;  // of a leaf's rows
    };
};

}  // namespace

struct photon_index {
    size_t columns;
    float low[COLUMNS_MAX], high[COLUMNS_MAX];  // bounds of the rows
    std::vector<Node> node;
    std::vector<int> row;     // in the tree's order
    std::vector<float> data;  // the same
};

namespace {

// What FLANN asks of a distance, of which building takes the types alone.
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

// Receives the tree as FLANN writes it: whether rows are copied, rows of a leaf, the bounds, the
// rows' order, then per node the ends of its rows, its column, its two limits, and whether it is a
// leaf.
class Reader final : public flann::serialization::OutputArchive<Reader> {
   public:
    explicit Reader(photon_index &index) : index_(index) {}

    template <typename T>
    Reader &operator&(const T &value) {
        flann::serialization::Serializer<T>::save(*this, value);
        return *this;
    }
    // The rows themselves and the parameters are known.
    template <typename D>
    Reader &operator&(const flann::NNIndex<D> &) {
        return *this;
    }
    Reader &operator&(const flann::Matrix<float> &) { return *this; }
    Reader &operator&(const std::vector<int> &order) {
        index_.row = order;
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
            (bounds_ % 2 ? index_.high : index_.low)[bounds_ / 2] = value;
            bounds_++;
        }
    }
    void save(bool leaf) {
        if (in_tree()) add(leaf);
    }

   private:
    bool in_tree() const { return !index_.row.empty(); }

    void add(bool leaf);

    photon_index &index_;
    std::vector<uint32_t> open_;  // nodes whose second child is to come
    int bounds_ = 0, numbers_ = 0, limits_ = 0;
    int number_[3];
    float limit_[2];
};

// The node is complete. After a leaf comes the second child of the last node that lacks one.
void Reader::add(bool leaf) {
    const uint32_t at = static_cast<uint32_t>(index_.node.size());
    if (at > 0 && index_.node.back().column < 0) {
        index_.node[open_.back()].second = at;
        open_.pop_back();
    }
    Node node = {leaf ? -1 : number_[2], 0, {limit_[0]}, {limit_[1]}};
    if (leaf) {
        node.begin = number_[0];
        node.end = number_[1];
    } else {
        open_.push_back(at);
    }
    index_.node.push_back(node);
    numbers_ = limits_ = 0;
}

template <size_t N>
void build(photon_index &index, const float *data, size_t rows) {
    {
        flann::KDTreeSingleIndex<Squared<N>> tree(
            flann::Matrix<float>(const_cast<float *>(data), rows, N),
            flann::KDTreeSingleIndexParams(LEAF_ROWS, false));
        tree.buildIndex();
        Reader reader(index);
        tree.serialize(reader);
    }
    index.node.shrink_to_fit();
    index.data.resize(rows * N);
    for (size_t i = 0; i < rows; i++)
        for (size_t k = 0; k < N; k++)
            index.data[i * N + k] = data[static_cast<size_t>(index.row[i]) * N + k];
}

// The nearest row.
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

// The k nearest rows in the caller's arrays: first they fill, then they are a heap with the
// farthest on top.
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

   private:
    // Puts an entry at place i or below it.
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

// One search.
template <size_t N, typename Found>
struct Search {
    const photon_index &index;
    const float *query;
    Found &found;
    float along2[N];  // by column, the terms of the squared distance from the box of the node under
                      // way
};

template <size_t N, typename Found>
void visit_leaf(Search<N, Found> &s, const Node &leaf) {
    const float worst = s.found.worst();
    const float *row = s.index.data.data() + static_cast<size_t>(leaf.begin) * N;
    for (int i = leaf.begin; i < leaf.end; i++, row += N) {
        float distance2 = 0.0f;
        for (size_t k = 0; k < N; k++) distance2 += square(s.query[k] - row[k]);
        if (distance2 < worst) s.found.add(distance2, s.index.row[static_cast<size_t>(i)]);
    }
}

// `distance2` is that of the query from the node's box.
template <size_t N, typename Found>
void visit(Search<N, Found> &s, uint32_t at, float distance2) {
    const Node &node = s.index.node[at];
    if (node.column < 0) {
        visit_leaf(s, node);
        return;
    }
    const float value = s.query[node.column];
    const bool first = (value - node.low) + (value - node.high) < 0.0f;
    const float cut = square(value - (first ? node.high : node.low));
    visit(s, first ? at + 1 : node.second, distance2);
    float &along2 = s.along2[node.column];
    const float before = along2;
    distance2 = distance2 + cut - before;
    along2 = cut;
    if (distance2 <= s.found.worst()) visit(s, first ? node.second : at + 1, distance2);
    along2 = before;
}

template <size_t N, typename Found>
void search(const photon_index &index, const float *query, Found &found) {
    Search<N, Found> s = {index, query, found, {}};
    float distance2 = 0.0f;
    for (size_t i = 0; i < N; i++) {
        if (query[i] < index.low[i]) s.along2[i] = square(query[i] - index.low[i]);
        if (query[i] > index.high[i]) s.along2[i] = square(query[i] - index.high[i]);
        distance2 += s.along2[i];
    }
    if (distance2 <= found.worst()) visit(s, 0, distance2);
}

bool finite(const float *q, size_t n) {
    float sum = 0.0f;
    for (size_t i = 0; i < n; i++) sum += q[i] * 0.0f;
    return sum == 0.0f;
}

template <size_t N>
void find(const photon_index &index, const float *query, int k, float far2, int *row,
          float *distance2) {
    if (k == 1) {
        Nearest nearest(far2);
        search<N>(index, query, nearest);
        if (nearest.row < 0) return;
        row[0] = nearest.row;
        distance2[0] = nearest.distance2;
    } else {
        NearestK nearest(k, far2, row, distance2);
        search<N>(index, query, nearest);
    }
}

}  // namespace

struct photon_index *photon_index_new(const float *data, size_t rows, int columns) {
    if (rows == 0 || rows > INT_MAX || (columns != 3 && columns != 6)) return nullptr;
    photon_index *index = nullptr;
    try {
        index = new photon_index();
        index->columns = static_cast<size_t>(columns);
        if (columns == 3)
            build<3>(*index, data, rows);
        else
            build<6>(*index, data, rows);
        return index;
    } catch (...) {  // lack of memory: FLANN throws nothing else here
        delete index;
        return nullptr;
    }
}

void photon_index_free(struct photon_index *index) { delete index; }

size_t photon_index_bytes(const struct photon_index *index) {
    if (!index) return 0;
    return sizeof *index + index->node.size() * sizeof(Node) + index->row.size() * sizeof(int) +
           index->data.size() * sizeof(float);
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
            find<3>(*index, query, k, far2, row, distance2);
        else
            find<6>(*index, query, k, far2, row, distance2);
    }
}
