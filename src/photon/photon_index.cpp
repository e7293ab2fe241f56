// SPDX-License-Identifier: Apache-2.0
// The kd-tree of photons: the only file on FLANN. It uses the library's classes, as the C functions
// open a team of threads and make three allocations for every call; measured on gather rays that is
// more than the search itself.
//
// FLANN is used within what was found to hold: one exact tree, no random seed, queries that are not
// finite kept out. It refers to the rows and keeps a copy of them in the order of its tree.
#include <flann/algorithms/kdtree_single_index.h>

#include <climits>
#include <cmath>
#include <cstdlib>
#include <new>

extern "C" {
#include "photon/photon_index.h"
}

namespace {

// Squared distance in N dimensions, for the compiler to unroll.
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

// The nearest row.
struct Nearest final : flann::ResultSet<float> {
    int row = -1;
    float distance2 = INFINITY;

    bool full() const override { return true; }
    void addPoint(float dist, size_t index) override {
        if (!(dist < distance2)) return;
        distance2 = dist;
        row = static_cast<int>(index);
    }
    float worstDist() const override { return distance2; }
};

// The k nearest rows in the caller's arrays: first they fill, then they are a heap with the
// farthest on top.
class NearestK final : public flann::ResultSet<float> {
   public:
    NearestK(int k, int *row, float *distance2) : k_(k), row_(row), distance2_(distance2) {}

    bool full() const override { return count_ == k_; }
    void addPoint(float dist, size_t index) override {
        if (count_ < k_) {
            row_[count_] = static_cast<int>(index);
            distance2_[count_++] = dist;
            if (count_ == k_)
                for (int i = k_ / 2; i-- > 0;) sink(i, distance2_[i], row_[i]);
        } else if (dist < distance2_[0]) {
            sink(0, dist, static_cast<int>(index));
        }
    }
    float worstDist() const override { return count_ == k_ ? distance2_[0] : INFINITY; }

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
    int *row_;
    float *distance2_;
};

bool finite(const float *q, size_t n) {
    float sum = 0.0f;
    for (size_t i = 0; i < n; i++) sum += q[i] * 0.0f;
    return sum == 0.0f;
}

}  // namespace

struct photon_index {
    photon_index(size_t n) : rows(n) {}
    virtual ~photon_index() {}
    virtual void find(flann::ResultSet<float> &found, const float *query) const = 0;
    virtual size_t columns() const = 0;
    const size_t rows;
};

namespace {

template <size_t N>
struct Tree final : photon_index {
    Tree(const float *data, size_t n)
        : photon_index(n),
          tree(flann::Matrix<float>(const_cast<float *>(data), n, N),
               flann::KDTreeSingleIndexParams(16)) {
        tree.buildIndex();
    }
    void find(flann::ResultSet<float> &found, const float *query) const override {
        static const flann::SearchParams exact(flann::FLANN_CHECKS_UNLIMITED, 0.0f, false);
        tree.findNeighbors(found, query, exact);
    }
    size_t columns() const override { return N; }
    flann::KDTreeSingleIndex<Squared<N>> tree;
};

}  // namespace

// Measured: a copy of the data and about 21 bytes of tree per row.
static size_t tree_bytes(size_t rows, size_t columns) {
    return rows * (sizeof(float) * columns + 21);
}

// FLANN's pool crashes without memory, so it is asked for before.
static bool memory_for(size_t bytes) {
    void *probe = std::malloc(bytes);
    std::free(probe);
    return probe != nullptr;
}

struct photon_index *photon_index_new(const float *data, size_t rows, int columns) {
    if (rows == 0 || rows > INT_MAX) return nullptr;
    // A third more for what is held while it is built.
    if (!memory_for(tree_bytes(rows, static_cast<size_t>(columns)) / 3 * 4)) return nullptr;
    try {
        if (columns == 3) return new Tree<3>(data, rows);
        if (columns == 6) return new Tree<6>(data, rows);
    } catch (...) {
    }
    return nullptr;
}

void photon_index_free(struct photon_index *index) { delete index; }

size_t photon_index_bytes(const struct photon_index *index) {
    return index ? tree_bytes(index->rows, index->columns()) : 0;
}

void photon_index_nearest(const struct photon_index *index, const float *query, size_t count, int k,
                          int *row, float *distance2) {
    const size_t columns = index->columns();
    for (size_t i = 0; i < count; i++, query += columns, row += k, distance2 += k) {
        for (int j = 0; j < k; j++) {
            row[j] = -1;
            distance2[j] = INFINITY;
        }
        if (!finite(query, columns)) continue;
        try {
            if (k == 1) {
                Nearest nearest;
                index->find(nearest, query);
                row[0] = nearest.row;
                distance2[0] = nearest.distance2;
            } else {
                NearestK nearest(k, row, distance2);
                index->find(nearest, query);
            }
        } catch (...) {  // no memory for a few floats: nothing is found
        }
    }
}
