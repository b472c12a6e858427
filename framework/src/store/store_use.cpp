#include "store/store_use.h"

namespace fresco::host
{

StoreUse::StoreUse(const Store& store) : store_(store), presence_(store), lock_(store_lock(store)) {}

bool StoreUse::try_enter()
{
    if (lock_.try_exclusive())
        for (const auto& path : abandoned_temporaries(store_))
            remove_quietly(path);
    return lock_.try_shared();
}

std::string StoreUse::tidier() const
{
    return FileLock::holder_of(store_.lock_file("store"));
}

}  // namespace fresco::host
