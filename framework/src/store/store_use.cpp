#include "store/store_use.h"
#include <fresco/error.h>

namespace fresco::host
{

StoreUse::StoreUse(const Store& store, const Store* lender) : store_(store), presence_(store), lock_(store_lock(store))
{
    if (lender == nullptr)
        return;
    try
    {
        lender_lock_ = store_lock(*lender);
        lender_lock_.try_shared();
    }
    catch (const Error&)
    {
        return;  // What is copied from there is verified.
    }
}

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
