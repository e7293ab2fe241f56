// SPDX-License-Identifier: Apache-2.0
// The search for the nearest rows of photon_index.cpp. It has the same steps as FLANN's, so it
// finds the same rows in the same order. Queries that are not finite find nothing.
//
// A lookup of light is a search for the one nearest row, which visits some 14 nodes and 1.5 leaves
// and mostly waits for memory and for jumps that no processor can predict. So SEARCHES queries
// descend together, without conditional jumps, and the leaves at their ends are prefetched.
#include <algorithm>
#include <cmath>
#include <cstring>

extern "C" {
#include "photon/photon_index_tree.h"
}

namespace {

enum {
    SEARCHES = 8,       // queries that descend together
    LINE = 16,          // floats of a cache line
    SUBTREES_MOST = 64  // subtrees that are left for later before the search calls itself
};
typedef float Lanes __attribute__((vector_size(PHOTON_INDEX_LANES * sizeof(float))));
typedef float UnalignedLanes
    __attribute__((vector_size(PHOTON_INDEX_LANES * sizeof(float)), aligned(4)));

// The result of a search for the nearest row.
struct Nearest {
    int row;
    float distance2;

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

// A subtree that is to be visited, unless its distance is too large by then.
template <size_t N>
struct Subtree {
    uint32_t at;
    float distance2;  // of the query from the box of its node
    float along2[N];  // the terms of distance2, by column
};

// The state of a search: it visits the subtree `here`, then the others from the last one on.
template <size_t N, typename Found>
struct Search {
    const float *query;
    Found found;
    Subtree<N> here;
    size_t others = 0;
    Subtree<N> other[SUBTREES_MOST];  // not initialised, as few are used

    Search() {}
    Search(const float *from, Found nothing) : query(from), found(nothing) {}
};

// Goes from a node to the child on the query's side, at the same distance, and leaves the other
// child for later. Chooses without conditional jumps, which could not be predicted. False if the
// node is a leaf or the search has no more space.
template <size_t N, typename Found>
bool step_down(const photon_index &index, Search<N, Found> &s) {
    Subtree<N> &here = s.here;
    const photon_index_node &node = index.node[here.at];
    if (node.column < 0 || s.others == SUBTREES_MOST) return false;
    const float value = s.query[node.column], low = node.low, high = node.high;
    const bool first = (value - low) + (value - high) < 0.0f;
    const uint32_t children[2] = {node.second, here.at + 1};
    const float limit[2] = {low, high};
    const float cut = square(value - limit[first]);
    Subtree<N> &later = s.other[s.others++];
    memcpy(later.along2, here.along2, sizeof later.along2);
    later.at = children[!first];
    later.distance2 = here.distance2 + cut - here.along2[node.column];
    later.along2[node.column] = cut;
    here.at = children[first];
    return true;
}

template <size_t N, typename Found>
void visit_leaf(const photon_index &index, const float *query, const photon_index_node &leaf,
                Found &found) {
    const float worst = found.worst();
    const size_t begin = static_cast<size_t>(leaf.begin);
    const size_t count = static_cast<size_t>(leaf.end - leaf.begin);
    const float *column = index.data + begin * N;
    for (size_t i = 0; i < count; i += PHOTON_INDEX_LANES) {
        Lanes distance2 = {};
        for (size_t k = 0; k < N; k++) {
            const Lanes row = *reinterpret_cast<const UnalignedLanes *>(column + k * count + i);
            const Lanes d = query[k] - row;
            distance2 += d * d;
        }
        const auto near = distance2 < worst;
        if (!(near[0] | near[1] | near[2] | near[3])) continue;
        for (size_t j = 0; j < PHOTON_INDEX_LANES && i + j < count; j++)
            if (near[j]) found.add(distance2[j], index.row[begin + i + j]);
    }
}

template <size_t N, typename Found>
void visit_subtree(const photon_index &index, Search<N, Found> &s);

// Visits the node below which the search cannot descend, and then the subtrees that are not farther
// than what was found.
template <size_t N, typename Found>
void finish_search(const photon_index &index, Search<N, Found> &s) {
    for (;;) {
        const photon_index_node &node = index.node[s.here.at];
        if (node.column < 0) {
            visit_leaf<N>(index, s.query, node, s.found);
        } else {
            Search<N, Found> below(s.query, s.found);
            below.here = s.here;
            visit_subtree(index, below);
            s.found = below.found;
        }
        do {
            if (s.others == 0) return;
            s.here = s.other[--s.others];
        } while (!(s.here.distance2 <= s.found.worst()));
        while (step_down(index, s)) {
        }
    }
}

template <size_t N, typename Found>
void visit_subtree(const photon_index &index, Search<N, Found> &s) {
    while (step_down(index, s)) {
    }
    finish_search(index, s);
}

// Sets `here` to the whole tree. False if nothing in it is near enough.
template <size_t N, typename Found>
bool begin_search(const photon_index &index, Search<N, Found> &s) {
    s.here = {};
    for (size_t i = 0; i < N; i++) {
        const float q = s.query[i];
        if (q < index.low[i]) s.here.along2[i] = square(q - index.low[i]);
        if (q > index.high[i]) s.here.along2[i] = square(q - index.high[i]);
        s.here.distance2 += s.here.along2[i];
    }
    return s.here.distance2 <= s.found.worst();
}

bool finite(const float *q, size_t n) {
    float sum = 0.0f;
    for (size_t i = 0; i < n; i++) sum += q[i] * 0.0f;
    return sum == 0.0f;
}

template <size_t N>
int find_few(const photon_index &index, const float *query, int k, float far2, int *row,
             float *distance2) {
    Search<N, NearestK> s(query, NearestK(k, far2, row, distance2));
    if (begin_search(index, s)) visit_subtree(index, s);
    return s.found.count();
}

template <size_t N>
void prefetch_leaf(const photon_index &index, const photon_index_node &leaf) {
    if (leaf.column >= 0) return;
    const size_t begin = static_cast<size_t>(leaf.begin), end = static_cast<size_t>(leaf.end);
    for (size_t i = begin * N; i < end * N; i += LINE) __builtin_prefetch(index.data + i);
    __builtin_prefetch(index.row + begin);
}

// The nearest row of up to SEARCHES queries. They descend together, so that they do not wait for
// each other's memory.
template <size_t N>
void find_nearest(const photon_index &index, const float *query, size_t count, float far2, int *row,
                  float *distance2) {
    Search<N, Nearest> search[SEARCHES];
    size_t searching = 0;
    size_t at[SEARCHES];
    for (size_t i = 0; i < count; i++) {
        Search<N, Nearest> &s = search[searching];
        s.query = query + i * N;
        s.found = {-1, far2};
        s.others = 0;
        if (finite(s.query, N) && begin_search(index, s)) at[searching++] = i;
    }
    for (bool descended = true; descended;) {
        descended = false;
        for (size_t i = 0; i < searching; i++) descended |= step_down(index, search[i]);
    }
    for (size_t i = 0; i < searching; i++) prefetch_leaf<N>(index, index.node[search[i].here.at]);
    for (size_t i = 0; i < searching; i++) {
        finish_search(index, search[i]);
        if (search[i].found.row < 0) continue;
        row[at[i]] = search[i].found.row;
        distance2[at[i]] = search[i].found.distance2;
    }
}

}  // namespace

void photon_index_nearest(const struct photon_index *index, const float *query, size_t count, int k,
                          float far2, int *row, float *distance2) {
    const size_t columns = index->columns;
    std::fill_n(row, count * static_cast<size_t>(k), -1);
    std::fill_n(distance2, count * static_cast<size_t>(k), INFINITY);
    const size_t step = k == 1 ? SEARCHES : 1;
    for (size_t i = 0; i < count;
         i += step, query += step * columns, row += step * k, distance2 += step * k) {
        const size_t now = std::min(step, count - i);
        if (k == 1 && columns == 3)
            find_nearest<3>(*index, query, now, far2, row, distance2);
        else if (k == 1)
            find_nearest<6>(*index, query, now, far2, row, distance2);
        else if (!finite(query, columns))
            continue;
        else if (columns == 3)
            find_few<3>(*index, query, k, far2, row, distance2);
        else
            find_few<6>(*index, query, k, far2, row, distance2);
    }
}

int photon_index_within(const struct photon_index *index, const float *query, int most, float r2,
                        int *row, float *distance2) {
    if (!finite(query, index->columns)) return 0;
    return index->columns == 3 ? find_few<3>(*index, query, most, r2, row, distance2)
                               : find_few<6>(*index, query, most, r2, row, distance2);
}
